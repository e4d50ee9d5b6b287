#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

namespace tenon::output_file_test {

namespace fs = std::filesystem;

class OutputFileTest : public ::testing::Test {
 protected:
  OutputFileTest() { fs::create_directory(directory_); }
  ~OutputFileTest() override { fs::remove_all(directory_); }
  const fs::path directory_ = test::TemporaryPath("tenon_output_file_test");
  const fs::path file_ = directory_ / "x.txt";
};

TEST_F(OutputFileTest, IsWrittenAsAWholeAndAlone) {
  WriteFile(file_, "a long text");
  WriteFile(file_, "short");
  EXPECT_EQ(ReadText(file_), "short");
  EXPECT_EQ(std::distance(fs::directory_iterator(directory_), {}), 1) << "nothing is left beside it";
}

TEST_F(OutputFileTest, WhatCannotBeWrittenIsNamedWithTheCause) {
  EXPECT_TRUE(Throws<OutputError>([&] { WriteFile(directory_ / "no" / "x.txt", "a"); }, "no/x.txt"));
  EXPECT_TRUE(Throws<OutputError>([&] { WriteFile("/dev/full", "a"); }, "'/dev/full'"));
  EXPECT_TRUE(Throws<OutputError>([&] { GrowingFile file(directory_); }, "Is a directory"));
  EXPECT_NO_THROW(WriteFile("/dev/null", "a"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(OutputFileTest, GrowsByWholeTexts) {
  {
    GrowingFile file(file_);
    file.Append("one\n");
    file.Append("");
    file.Append("two\n");
    EXPECT_TRUE(Throws<OutputError>([&] { GrowingFile second(file_); }, file_.string(), "another log"));
    EXPECT_EQ(ReadText(file_), "one\ntwo\n");
  }
  GrowingFile anew(file_);
  EXPECT_EQ(ReadText(file_), "");
  EXPECT_NO_THROW(GrowingFile("/dev/null").Append("a"));
}

}  // namespace tenon::output_file_test
