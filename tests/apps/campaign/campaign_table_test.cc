#include <tenon/apps/campaign/campaign_runner.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

namespace tenon::apps::campaign_table_test {

namespace fs = std::filesystem;

CampaignRow Row(int run, const std::string& error, const std::string& mpc = "") {
  CampaignRow row{{"run", std::to_string(run)}, {"case", "D1"}, {"error_m", error}};
  if (!mpc.empty()) row.insert(row.begin() + 2, {"mpc", mpc});
  row.emplace_back("end_reason", "end of the run");
  return row;
}

struct CampaignTableTest : ::testing::Test {
  ~CampaignTableTest() override { fs::remove(file); }
  std::string Text() const { return ReadText(file); }
  const fs::path file = test::TemporaryPath("tenon_campaign_table.csv");
};

TEST_F(CampaignTableTest, ARowIsThereAsSoonAsItIsAdded) {
  CampaignTable table(file, CampaignTable::Start::kNew);
  table.Append(Row(3, "0.5"));
  EXPECT_EQ(Text(), "run,case,error_m,end_reason\n3,D1,0.5,end of the run\n");
  table.Append({{"run", "1"}, {"end_reason", "fell, \"hard\"\non its side"}});
  EXPECT_THAT(Text(), ::testing::HasSubstr("\n1,,,\"fell, \"\"hard\"\" on its side\"\n"));
  CampaignRow read;
  CampaignTable::Read(file, 10, [&](std::size_t run, const CampaignRow& row) {
    if (run == 1) read = row;
  });
  EXPECT_EQ(Cell(read, "end_reason"), "fell, \"hard\" on its side");
  EXPECT_EQ(Cell(read, "error_m"), "");
}

// The file does not depend on the order in which runs end, and runs may have different figures.
TEST_F(CampaignTableTest, TheSameRowsMakeTheSameFile) {
  const std::vector<CampaignRow> rows{Row(0, "0.1"), Row(1, "0.2", "7"), Row(2, "NaN"), Row(3, "0.4", "8")};
  std::string first;
  std::vector<std::size_t> order{0, 1, 2, 3};
  do {
    CampaignTable table(file, CampaignTable::Start::kNew);
    for (const std::size_t i : order) table.Append(rows[i]);
    table.Finish([](std::size_t run) { return run != 2; });
    if (first.empty()) first = Text();
    EXPECT_EQ(Text(), first);
  } while (std::ranges::next_permutation(order).found);
  EXPECT_EQ(first,
            "run,case,mpc,error_m,end_reason\n0,D1,,0.1,end of the run\n1,D1,7,0.2,end of the run\n"
            "3,D1,8,0.4,end of the run\n");
}

TEST_F(CampaignTableTest, ResumesTheTableOfAKilledWriterWithoutItsTornLine) {
  { std::ofstream(file) << "run,case,end_reason\n4,D1,end of the run\n2,D1,end of t"; }
  {
    CampaignTable table(file, CampaignTable::Start::kResume);
    EXPECT_EQ(Text(), "run,case,end_reason\n4,D1,end of the run\n");
    table.Append({{"run", "2"}, {"case", "D1"}, {"end_reason", "end of the run"}});
    EXPECT_EQ(Text(), "run,case,end_reason\n4,D1,end of the run\n2,D1,end of the run\n");
  }
  { std::ofstream(file) << "run,ca"; }  // before the first row
  CampaignTable anew(file, CampaignTable::Start::kResume);
  anew.Append(Row(0, "1"));
  EXPECT_EQ(Text(), "run,case,error_m,end_reason\n0,D1,1,end of the run\n");
}

TEST_F(CampaignTableTest, MayHaveNoRowsAndNoneTwice) {
  CampaignTable table(file, CampaignTable::Start::kNew);
  table.Finish([](std::size_t) { return true; });
  EXPECT_EQ(Text(), "");
  CampaignTable::Read(file, 10, [](std::size_t, const CampaignRow&) { ADD_FAILURE(); });
  table.Append(Row(4, "1"));
  table.Append(Row(4, "1"));
  table.Finish([](std::size_t) { return true; });
  EXPECT_EQ(Text(), "run,case,error_m,end_reason\n4,D1,1,end of the run\n");
}

TEST_F(CampaignTableTest, RefusesFilesThatAreNoTables) {
  const auto read = [this] { CampaignTable::Read(file, 10, [](std::size_t, const CampaignRow&) {}); };
  EXPECT_TRUE(Throws<ParameterError>(read, file.string()));
  for (const auto& [text, place] : {std::pair{"time,x\n1,2\n", ":1: "},
                                    {"run,x\n1,2\n3\n", ":3: "},
                                    {"run,x\n,2\n", ":2: "},
                                    {"run,x\n-1,2\n", ":2: "},
                                    {"run,x\n1x,2\n", ":2: "},
                                    {"run,x\n99999999999999999999999,2\n", ":2: "},
                                    {"run,x\n10,2\n", ":2: run 10 "}}) {
    std::ofstream(file) << text;
    EXPECT_TRUE(Throws<ParameterError>(read, place)) << text;
  }
  EXPECT_TRUE(Throws<OutputError>(
      [] { CampaignTable table("/no/such/runs.csv", CampaignTable::Start::kNew); }, "/no/such/runs.csv"));
}

}  // namespace tenon::apps::campaign_table_test
