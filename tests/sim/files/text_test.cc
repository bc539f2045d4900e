#include "sim/files/text.h"

#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "sim/files/csv.h"
#include "sim/files/json.h"
#include "sim/files/trajectory_file.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::files {
namespace {

using testing::ElementsAre, testing::HasSubstr, testing::StartsWith;

TEST(Text, IsReadBackByteForByte) {
  const TemporaryFolder folder;
  fs::create_symlink("a", folder / "link");
  for (const std::string& text :
       {std::string(), std::string("a\r\n\0\xff b\n", 8), std::string(200'000, 'x')}) {
    write_text(folder / "a", text);
    EXPECT_EQ(read_text(folder / "a"), text);
    EXPECT_EQ(read_text(folder / "link"), text);
  }
}

TEST(Text, AFileThatCannotBeReadOrWrittenIsReportedWithTheReason) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { read_text(folder / "none"); }),
              HasSubstr("none: cannot be read: No such file or directory"));
  EXPECT_THAT(error_of([&] { read_text(folder.path()); }), HasSubstr(": cannot be read: Is a directory"));
  EXPECT_THAT(error_of([&] { write_text(folder / "none/a", "x"); }),
              HasSubstr("none/a: cannot be written: No such file or directory"));
  EXPECT_THAT(error_of([&] { write_text("/dev/full", "x"); }),
              HasSubstr("/dev/full: cannot be written: No space left on device"));
}

// Opening a pipe without a writer would block forever.
TEST(InputFile, IsRejectedAtOnceIfNotRegular) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  fs::create_symlink("pipe", folder / "link");
  fs::create_symlink("/dev/zero", folder / "device");
  for (const char* name : {"pipe", "link", "device"}) {
    const fs::path file = folder / name;
    const std::function<void()> readers[] = {
        [&] { read_text(file); }, [&] { read_json(file); }, [&] { CsvReader rows(file); },
        [&] { CsvReader rows(file, {"a,b"}); }, [&] { read_trajectory(file); }};
    for (const auto& read : readers)
      EXPECT_THAT(error_of(read), HasSubstr(std::string(name) + ": is not a regular file, expected one"));
  }
}

// A pipe like the one that a shell passes for <(...).
TEST(InputFile, MayBeAPipeOfThisProcessUpToTheLimit) {
  for (const std::uintmax_t most : {8u, 7u}) {
    int ends[2] = {};
    ASSERT_EQ(::pipe(ends), 0);
    ASSERT_EQ(::write(ends[1], "a,b\n1,2\n", 8), 8);
    ::close(ends[1]);
    const auto read = [&] { return read_text("/dev/fd/" + std::to_string(ends[0]), most); };
    if (most == 8)
      EXPECT_EQ(read(), "a,b\n1,2\n");
    else
      EXPECT_THAT(error_of(read), HasSubstr(": has more than 7 bytes"));
    ::close(ends[0]);
  }
}

// Sparse files take no space on the disk.
TEST(InputFile, IsRejectedBeforeItIsReadIfTooLarge) {
  const TemporaryFolder folder;
  const auto sparse = [&](const std::string& name, std::uintmax_t bytes) {
    write_text(folder / name, "");
    fs::resize_file(folder / name, bytes);
    return folder / name;
  };
  const fs::path large = sparse("large", 3221225473);
  EXPECT_THAT(error_of([&] { read_text(large); }),
              HasSubstr("large: has 3221225473 bytes, expected at most 2147483648"));
  EXPECT_THAT(error_of([&] { read_json(large); }), HasSubstr("expected at most 67108864"));
  const fs::path largest = sparse("largest", std::uintmax_t{1} << 40);
  EXPECT_THAT(error_of([&] { CsvReader rows(largest); }),
              HasSubstr("has 1099511627776 bytes, expected at most 17179869184"));
  EXPECT_THAT(error_of([&] { CsvReader rows(large); }),
              HasSubstr("large: is compressed, binary, UTF-16 or UTF-32"));
}

TEST(Sanitize, ControlCharactersAreReplaced) {
  EXPECT_EQ(sanitize("\x1b]0;title\x07\x1b[2J"), "?]0;title??[2J");
  EXPECT_EQ(sanitize("del\x7f nul" + std::string(1, '\0')), "del? nul?");
  EXPECT_EQ(sanitize("\xc2\x9bK"), "?K") << "U+009B, CSI";
  EXPECT_EQ(sanitize("\xe2\x80\xaex\xe2\x81\xa6y"), "?x?y") << "U+202E and U+2066";
  EXPECT_EQ(sanitize("\x9bK \xc3 \xe2\x80"), "?K ? ??") << "no UTF-8";
  EXPECT_EQ(sanitize("\xed\xa0\x80 \xed\xbf\xbf"), "??? ???") << "surrogates";
  EXPECT_EQ(sanitize("\xe0\x80\xaf \xf0\x80\x80\xaf \xf4\x90\x80\x80"), "??? ???? ????")
      << "overlong, too large";
  EXPECT_EQ(sanitize("\xef\xbf\xbe\xef\xbf\xbf"), "??") << "U+FFFE and U+FFFF";
}

TEST(Sanitize, OtherTextIsUnchanged) {
  for (const char* text :
       {"", "two\nlines\tand a tab", "Gr\xc3\xb6\xc3\x9fung \xe2\x82\xac \xf0\x9f\x98\x80",
        "\xe0\xa0\x80 \xed\x9f\xbf \xee\x80\x80 \xef\xbf\xbd \xf0\x90\x80\x80 \xf4\x8f\xbf\xbf"})
    EXPECT_EQ(sanitize(text), text);
}

TEST(Sanitize, AShellWordIsQuotedIfNeeded) {
  EXPECT_EQ(shell_word("results/walk-1/seed=1,2:@%+.yaml"), "results/walk-1/seed=1,2:@%+.yaml");
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("a;touch b;#"), "'a;touch b;#'");
  EXPECT_EQ(shell_word("`id` it's \n"), "'`id` it'\\''s \n'");
}

TEST(Sanitize, ErrorsAndTablesContainNoControlCharacters) {
  EXPECT_STREQ(FileError("a\x1b", 2, 3, "no \x07").what(), "a?:2:3: no ?");
  EXPECT_EQ(text_table({{"name"}, {"\x1b[2J"}}, {}).find('\x1b'), std::string::npos);
}

TEST(TextTable, ColumnsAreAsWideAsTheyNeedToBe) {
  EXPECT_EQ(text_table({{"name", "n"}, {"a", "1"}, {"a", "10"}, {"b", "2"}}, {}),
            "name   n\na      1\na     10\n\nb      2\n");
}

TEST(TextTable, LongTitlesAreBrokenBeforeColumnsAreMoved) {
  const std::string text =
      text_table({{"s", "slam.vision.sigma_px", "x"}, {"hall", "0.5", "1"}}, {.width = 24});
  EXPECT_EQ(text, "         slam.\n       vision.\ns     sigma_px  x\nhall       0.5  1\n");
}

TEST(TextTable, NoLineIsWiderThanRequested) {
  std::vector<std::vector<std::string>> rows{{"scenario"}, {"tangent_circle"}};
  for (int i = 0; i < 12; ++i) {
    rows[0].push_back("navigation_end_position_error_m" + std::to_string(i));
    rows[1].push_back("0.01234");
  }
  const std::string text = text_table(rows, {});
  int named = 0;
  for (const std::string& line : lines_of(text)) {
    EXPECT_LE(line.size(), kTerminalWidth) << line;
    named += line.starts_with("tangent_circle");
  }
  EXPECT_EQ(named, 2) << "each table repeats the naming column";
  for (int i = 0; i < 12; ++i) EXPECT_THAT(text, HasSubstr("m" + std::to_string(i)));
}

TEST(ContainedPath, NamesAndLinksThatLeadOutAreRejected) {
  const TemporaryFolder folder;
  const fs::path root = folder / "root";
  fs::create_directories(root / "below");
  write_text(root / "below/a.txt", "inside");
  write_text(folder / "secret.txt", "outside");
  fs::create_symlink(folder / "secret.txt", root / "link.txt");
  fs::create_directory_symlink(folder.path(), root / "up");
  fs::create_directory_symlink(folder.path(), root / "below/up");
  fs::create_symlink("below/a.txt", root / "near.txt");
  fs::create_symlink("loop", root / "loop");
  fs::create_directory_symlink(root, folder / "alias");

  EXPECT_EQ(contained_path(root, "not/there/yet"), root / "not/there/yet");
  EXPECT_EQ(contained_path(root, "..a"), root / "..a") << "two dots in front of a name";
  EXPECT_EQ(read_text(contained_path(root, "near.txt")), "inside");
  EXPECT_EQ(read_text(contained_path(folder / "alias", "below/a.txt")), "inside") << "itself a link";
  for (const std::string& name :
       {std::string(), std::string("../secret.txt"), std::string("below/../../secret.txt"),
        std::string("below/.."), std::string("/etc/passwd"), std::string("//etc/passwd"),
        std::string("a\0b", 3), std::string("below/up/secret.txt"), std::string("link.txt"),
        std::string("up/secret.txt")})
    EXPECT_THAT(error_of([&] { contained_path(root, name); }), testing::HasSubstr("leads outside the folder"))
        << name;
  EXPECT_THROW(contained_path(root, "loop"), FileError);
}

class CsvTest : public testing::Test {
 protected:
  fs::path file(const std::string& text) const {
    write_text(folder_ / "rows.csv", text);
    return folder_ / "rows.csv";
  }
  std::vector<std::vector<std::string>> rows(const std::string& text) const {
    std::vector<std::vector<std::string>> all;
    for (CsvReader csv(file(text)); csv.next();) {
      all.emplace_back();
      for (std::size_t i = 0; i < csv.fields(); ++i) all.back().emplace_back(csv.text(i));
    }
    return all;
  }
  std::string complaint(const std::string& text) const {
    return error_of([&] { rows(text); }).substr(folder_.path().string().size() + 1);
  }
  const TemporaryFolder folder_;
};

TEST_F(CsvTest, AQuotedFieldIsReadLiterally) {
  EXPECT_THAT(rows("a,b\n\"1, 2\",3\n"), ElementsAre(ElementsAre("1, 2", "3")));
  EXPECT_THAT(rows("a,b\n\"\",\" say \"\"no\"\" \"\r\n"), ElementsAre(ElementsAre("", " say \"no\" ")));
  EXPECT_THAT(rows("\xef\xbb\xbf\"a,\",b\n1,2"), ElementsAre(ElementsAre("1", "2")));
  EXPECT_THAT(rows("a,b\n 5\" ,x\"y\"\n"), ElementsAre(ElementsAre("5\"", "x\"y\""))) << "within a field";
  EXPECT_THAT(rows("a\n" + csv_field("two\nlines \"\"") + "\n"), ElementsAre(ElementsAre("two lines \"\"")));
}

TEST_F(CsvTest, UntrustedNamesBecomeNeitherFormulasNorCommands) {
  const std::map<std::string, std::string> fields{{"=1+1", "'=1+1"},        {"@sum", "'@sum"},
                                                  {"-0.5", "-0.5"},         {"-x,y", "\"'-x,y\""},
                                                  {"a\x1b[2J\n", "a?[2J?"}, {"plain", "plain"}};
  for (const auto& [name, field] : fields) EXPECT_EQ(neutral_field(name), field);
}

TEST_F(CsvTest, QuotingErrorsAreReportedWithTheirPlace) {
  EXPECT_EQ(complaint("a,b\n1,\"2\n3,4\n"), "rows.csv:2: a quoted field is not closed");
  EXPECT_EQ(complaint("a,b\n\"1\"2,3\n"), "rows.csv:2:4: expected a comma after the quoted field");
  EXPECT_EQ(complaint("a,b\n\"1\",2\n3\n"), "rows.csv:3: expected 2 fields, found 1");
  EXPECT_EQ(complaint("\""), "rows.csv:1: a quoted field is not closed");
}

TEST_F(CsvTest, NumbersMayBeQuotedAndErrorsNameTheirColumn) {
  CsvReader csv(file("a,b\n\"1.5\",\"x\"\n"));
  ASSERT_TRUE(csv.next());
  EXPECT_EQ(csv.number(0), 1.5);
  EXPECT_THAT(error_of([&] { csv.number(1); }),
              testing::EndsWith("rows.csv:2:8: expected a finite number, found \"x\""));
}

std::string json_complaint(const std::string& text, const std::function<void(const Json&)>& read) {
  const std::string error = error_of([&] { read(Json("a.json", text)); });
  EXPECT_TRUE(error.empty() || error.starts_with("a.json: ")) << error;
  return error.substr(std::min<std::size_t>(error.size(), 8));
}

TEST(Json, ValuesAreReadWithTheirTypes) {
  const Json json("a.json", R"({"t": "x", "n": -1.5, "w": 18446744073709551615, "f": true, "nothing": null,
                                "list": [1, {"deep": "y"}], "object": {"b": 1, "a": 2}})");
  EXPECT_EQ(json.at("t").text(), "x");
  EXPECT_EQ(json.at("n").number(), -1.5);
  EXPECT_EQ(json.at("w").whole(), 18446744073709551615u);
  EXPECT_TRUE(json.at("f").flag());
  EXPECT_FALSE(json.at("nothing").number_or_null());
  EXPECT_FALSE(json.find("nothing"));
  EXPECT_FALSE(json.find("else"));
  EXPECT_EQ(json.at("list").items()[1].at("deep").text(), "y");
  EXPECT_EQ(json.at("object").entries()[0].first, "b") << "the order of the file";
}

TEST(Json, AWrongTypeIsReportedWithFileAndKey) {
  const std::string text = R"({"a": {"b": [1, "x"]}, "n": -1, "f": 1.5, "t": "x", "o": {}})";
  const auto says = [&](const char* key, const auto& read) {
    return json_complaint(text, [&](const Json& j) { read(j.at(key)); });
  };
  EXPECT_EQ(says("a", [](const Json& j) { j.text(); }), "a: expected text, found object");
  EXPECT_EQ(says("a", [](const Json& j) { j.at("b").items()[1].number(); }),
            "a.b[1]: expected a number, found string");
  EXPECT_EQ(says("a", [](const Json& j) { j.at("c"); }), "a.c: is missing");
  EXPECT_EQ(says("t", [](const Json& j) { j.find("c"); }), "t: expected an object, found string");
  for (const char* key : {"n", "f"})
    EXPECT_EQ(says(key, [](const Json& j) { j.whole(); }),
              key + std::string(": expected a whole number from 0, found number"));
  EXPECT_EQ(says("f", [](const Json& j) { j.flag(); }), "f: expected true or false, found number");
  EXPECT_EQ(says("o", [](const Json& j) { j.items(); }), "o: expected a list, found object");
}

TEST(Json, OnlyObjectsAreAccepted) {
  for (const char* text : {"", "{", "[]", "1", "null", "{\"a\": 1e999}", "{} {}", "\xff"})
    EXPECT_THROW(Json("a.json", text), FileError) << text;
}

// Printing a deeper tree would exhaust the stack.
TEST(Json, ADeepTreeIsRejected) {
  const auto nested = [](int depth) {
    return "{\"a\": " + std::string(std::size_t(depth), '[') + std::string(std::size_t(depth), ']') + "}";
  };
  EXPECT_EQ(json_complaint(nested(60), [](const Json&) {}), "");
  EXPECT_THAT(json_complaint(nested(1'000'000), [](const Json&) {}), StartsWith("is nested deeper"));
}

TEST(Json, BytesThatAreNotUtf8AreReplaced) {
  EXPECT_EQ(json_text({{"file", "a\xff"}}), "{\"file\":\"a\xef\xbf\xbd\"}");
}

}  // namespace
}  // namespace sim::files
