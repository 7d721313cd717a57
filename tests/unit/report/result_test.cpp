#include "report/result.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "report/format.hpp"
#include "support.hpp"

namespace sandglass::report {
namespace {

using nlohmann::json;
using testing::HasSubstr;

Result example() {
  Result result;
  result.status = "mismatch";
  result.exit_code = 6;
  result.error = "line one\nline \"two\"";
  result.wall_time_s = 4.25;
  result.windows = 30;
  result.overhead_s_per_window = 2.1e-5;
  result.quantities["speed"] = {0.5, "m/s", "at the end"};
  result.quantities["table"] = {Value::List{1.0, not_a_number}, "1", ""};
  result.quantities["box"] = {Value(), "1", ""};
  ComparisonResult made;
  made.name = "printed";
  made.metric = "relative difference";
  made.value = 6e-5;
  made.tolerance = 1e-4;
  made.passed = true;
  made.reference = 0.1;
  made.ours = 0.3;
  made.unit = "m/s";
  made.shown_in = "mm/s";
  made.because = "four digits";
  made.source = "section 3";
  made.points = 7;
  made.to = 0.03;
  ComparisonResult skipped;
  skipped.name = "figure 2";
  skipped.metric = "value";
  skipped.skipped = "density departs from 2650 kg/m3";
  ComparisonResult broken;
  broken.name = "broken";
  broken.metric = "value";
  broken.value = not_a_number;
  broken.passed = false;
  result.comparisons = {made, skipped, broken};
  result.left_out = {{"unit_answer", "fluid solve", "linear", 25.1},
                     {"position", "field", "nobody reads it", {}}};
  result.notes = {{"fluid", "Re = 0.9"}};
  result.curves["velocity"] = "stages/analyse/velocity.csv";
  return result;
}

TEST(ResultFile, HasTheKeysThatItPromises) {
  const json document = json::parse(to_json(example()));
  EXPECT_EQ(document.at("format"), 1);
  EXPECT_EQ(document.at("status"), "mismatch");
  EXPECT_EQ(document.at("exit_code"), 6);
  EXPECT_EQ(document.at("wall_time_s"), 4.25);
  EXPECT_EQ(document.at("windows"), 30);
  EXPECT_EQ(document.at("overhead_s_per_window"), 2.1e-5);
  EXPECT_EQ(document.at("quantities").at("speed").at("value"), 0.5);
  EXPECT_EQ(document.at("quantities").at("speed").at("unit"), "m/s");
  EXPECT_TRUE(document.at("quantities").at("table").at("value").at(1).is_null());
  EXPECT_TRUE(document.at("quantities").at("box").at("value").is_null());
  const json& comparisons = document.at("comparisons");
  EXPECT_EQ(comparisons.at(0).at("value"), 6e-5);
  EXPECT_EQ(comparisons.at(0).at("passed"), true);
  EXPECT_FALSE(comparisons.at(0).contains("skipped"));
  EXPECT_TRUE(comparisons.at(1).at("passed").is_null());
  EXPECT_EQ(comparisons.at(1).at("skipped"), "density departs from 2650 kg/m3");
  EXPECT_FALSE(comparisons.at(1).contains("value"));
  EXPECT_TRUE(comparisons.at(2).at("value").is_null());
  EXPECT_EQ(comparisons.at(2).at("passed"), false);
  EXPECT_EQ(document.at("left_out").at(0).at("saving_s"), 25.1);
  EXPECT_FALSE(document.at("left_out").at(1).contains("saving_s"));
  EXPECT_EQ(document.at("curves").at("velocity"), "stages/analyse/velocity.csv");
}

TEST(ResultFile, ComesBackAsItWas) {
  const Folder folder;
  write_result(example(), folder.path());
  const Result read = read_result(folder.path());
  EXPECT_EQ(to_json(read), to_json(example()));
  EXPECT_EQ(read.error, "line one\nline \"two\"");
  EXPECT_TRUE(std::isnan(*read.comparisons.at(2).value));
  EXPECT_EQ(read.comparisons.at(1).passed, std::nullopt);
  EXPECT_EQ(read.comparisons.at(0).points, 7);
}

TEST(ResultFile, AnEmptyRunAndBytesThatAreNoTextAreWritten) {
  Result result;
  result.status = "failed";
  result.exit_code = 4;
  result.error = "log: \xff\xfe\x00 end";
  EXPECT_THAT(result_from_json(to_json(result), "x").error, HasSubstr("log: \ufffd"));
}

TEST(ResultFile, WhatIsNoneIsRefused) {
  const Folder folder;
  for (const char* text : {"", "{", "[]", "{}", R"({"format": 1})", R"({"format": 2})",
                           R"({"format": 1, "status": 7, "exit_code": "x"})"}) {
    folder.write("result.json", text);
    const auto [code, message] = error_of([&] { read_result(folder.path()); });
    EXPECT_EQ(code, ExitCode::environment) << text;
    EXPECT_THAT(message, HasSubstr("result.json"));
  }
}

TEST(ResultFile, StatusNamesFollowTheExitCodes) {
  EXPECT_EQ(status_name(ExitCode::done), "done");
  EXPECT_EQ(status_name(ExitCode::participant), "failed");
  EXPECT_EQ(status_name(ExitCode::unstable), "unstable");
  EXPECT_EQ(status_name(ExitCode::mismatch), "mismatch");
  EXPECT_EQ(status_name(ExitCode::interrupted), "interrupted");
}

TEST(Pretty, Numbers) {
  EXPECT_EQ(pretty_number(0.0089885), "0.0089885");
  EXPECT_EQ(pretty_number(2650), "2650");
  EXPECT_EQ(pretty_number(-0.5), "−0.5");
  EXPECT_EQ(pretty_number(6.1e-5), "6.1×10⁻⁵");
  EXPECT_EQ(pretty_number(1e-4), "0.0001");
  EXPECT_EQ(pretty_number(1e-5), "10⁻⁵");
  EXPECT_EQ(pretty_number(-1.25e12), "−1.25×10¹²");
  EXPECT_EQ(pretty_number(999999.9999), "1000000");
  EXPECT_EQ(pretty_number(0), "0");
  EXPECT_EQ(pretty_number(not_a_number), "not finite");
}

TEST(Pretty, UnitsAndQuantities) {
  EXPECT_EQ(pretty_unit("m/s2"), "m/s²");
  EXPECT_EQ(pretty_unit("m^-2 s-1"), "m⁻² s⁻¹");
  EXPECT_EQ(pretty_unit("kg/m3"), "kg/m³");
  EXPECT_EQ(pretty_unit("1"), "");
  EXPECT_EQ(pretty_quantity(0.0089885, "mm/s", 4), "8.989\u00a0mm/s");
  EXPECT_EQ(pretty_quantity(0.3, "deg", 4), "17.19°");
  EXPECT_EQ(pretty_percent(6e-5), "0.006\u00a0%");
  EXPECT_EQ(pretty_seconds(2.1e-5), "21\u00a0µs");
  EXPECT_EQ(pretty_seconds(4325), "1\u00a0h\u00a012\u00a0min");
  EXPECT_EQ(pretty_bytes(1.9e8), "190\u00a0MB");
}

}  // namespace
}  // namespace sandglass::report
