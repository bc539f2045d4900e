#include "sim/files/printed_text.h"

#include <gtest/gtest.h>

#include "sim/files/file_error.h"
#include "sim/files/text_table.h"

namespace sim::files {
namespace {

TEST(PrintedText, WhatATerminalObeysIsReplaced) {
  EXPECT_EQ(without_controls("\x1b]0;title\x07\x1b[2J"), "?]0;title??[2J");
  EXPECT_EQ(without_controls("del\x7f nul" + std::string(1, '\0')), "del? nul?");
  EXPECT_EQ(without_controls("\xc2\x9bK"), "?K") << "U+009B, CSI";
  EXPECT_EQ(without_controls("\xe2\x80\xaex\xe2\x81\xa6y"), "?x?y") << "U+202E and U+2066";
  EXPECT_EQ(without_controls("\x9bK \xc3 \xe2\x80"), "?K ? ??") << "no UTF-8";
}

TEST(PrintedText, OtherTextStaysAsItIs) {
  for (const char* text :
       {"", "two\nlines\tand a tab", "Gr\xc3\xb6\xc3\x9fung \xe2\x82\xac \xf0\x9f\x98\x80"})
    EXPECT_EQ(without_controls(text), text);
}

TEST(PrintedText, AWordOfAShellIsQuotedWhereItHasToBe) {
  EXPECT_EQ(shell_word("results/walk-1/seed=1,2:@%+.yaml"), "results/walk-1/seed=1,2:@%+.yaml");
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("a;touch b;#"), "'a;touch b;#'");
  EXPECT_EQ(shell_word("`id` it's \n"), "'`id` it'\\''s \n'");
}

TEST(PrintedText, ErrorsAndTablesHaveNoControls) {
  EXPECT_STREQ(FileError("a\x1b", 2, 3, "no \x07").what(), "a?:2:3: no ?");
  EXPECT_EQ(text_table({{"name"}, {"\x1b[2J"}}, {}).find('\x1b'), std::string::npos);
}

}  // namespace
}  // namespace sim::files
