#include "sim/tune/value_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sim::tune {
namespace {

using scenario::ConfigError;
using scenario::Yaml;
using testing::ElementsAre;
using testing::HasSubstr;

Yaml scalar(const std::string& text) {
  Yaml node;
  node.kind = Yaml::Kind::scalar;
  node.text = text;
  node.origin = {"spec.yaml", 4, 7};
  return node;
}

std::vector<std::string> values(const std::string& text) {
  std::vector<std::string> texts;
  for (const Yaml& value : values_of(scalar(text))) {
    EXPECT_EQ(value.origin.line, 4);
    texts.push_back(value.text);
  }
  return texts;
}

std::string complaint(const std::string& text) {
  try {
    values_of(scalar(text));
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

TEST(ValueList, APlainValueIsItself) { EXPECT_THAT(values("0.50"), ElementsAre("0.50")); }

TEST(ValueList, ARangeHasItsLastValueWhereAStepMeetsIt) {
  EXPECT_THAT(values("range(0, 0.3, 0.1)"), ElementsAre("0", "0.1", "0.2", "0.3"));
  EXPECT_THAT(values("range(1,6,2)"), ElementsAre("1", "3", "5"));
  EXPECT_THAT(values("range(3, 1, -1)"), ElementsAre("3", "2", "1"));
  EXPECT_THAT(values("range(2, 2, 1)"), ElementsAre("2"));
}

TEST(ValueList, SpacesAreEvenOrOfEvenFactors) {
  EXPECT_THAT(values("linspace(-1, 1, 5)"), ElementsAre("-1", "-0.5", "0", "0.5", "1"));
  EXPECT_THAT(values("logspace(0.001, 10, 5)"), ElementsAre("0.001", "0.01", "0.1", "1", "10"));
}

TEST(ValueList, WhatIsWrongIsNamedWithItsPlace) {
  EXPECT_EQ(complaint("rang(0, 1, 2)"), "spec.yaml:4:7: unknown function 'rang'; did you mean 'range'?");
  EXPECT_THAT(complaint("range(0, 1)"), HasSubstr("has 2 numbers, expected range(first, last, step)"));
  EXPECT_THAT(complaint("range(0, 1, x)"), HasSubstr("'x' is no number"));
  EXPECT_THAT(complaint("range(0, 1, -0.1)"), HasSubstr("no step of -0.1 leads from 0 to 1"));
  EXPECT_THAT(complaint("range(0, 1, 0)"), HasSubstr("step"));
  EXPECT_THAT(complaint("range(0, 1e9, 1)"), HasSubstr("more than 100000 values"));
  EXPECT_THAT(complaint("linspace(0, 1, 1.5)"), HasSubstr("1.5 values, expected a whole number from 2"));
  EXPECT_THAT(complaint("logspace(-3, -1, 5)"), HasSubstr("expected bounds above 0, not their exponents"));
  EXPECT_THAT(complaint("range(0"), HasSubstr("put it in quotes"));
  EXPECT_THAT(complaint("uniform(0, 1)"), HasSubstr("is for samples"));
}

TEST(ValueList, CommasWithinBracketsAndQuotesDoNotSplit) {
  const auto pieces = split_at_commas("a,range(1, 2),[3, 4],'5,6'");
  ASSERT_EQ(pieces.size(), 4u);
  EXPECT_EQ(pieces[1].text, "range(1, 2)");
  EXPECT_EQ(pieces[1].begin, 2u);
  EXPECT_EQ(pieces[2].text, "[3, 4]");
  EXPECT_EQ(pieces[3].text, "'5,6'");
}

}  // namespace
}  // namespace sim::tune
