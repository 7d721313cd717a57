#include "report/page.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "report/result.hpp"
#include "support.hpp"

namespace sandglass::report {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

class Page : public testing::Test {
 protected:
  Page() { tools_.templates_root = SANDGLASS_SOURCE_DIR "/templates"; }
  std::string page() {
    incomplete_ = write_report(folder_.path(), tools_);
    return read_file(folder_.path() + "/report.html");
  }
  Folder folder_;
  ReportTools tools_;
  std::vector<std::string> incomplete_;
};

const char* const hostile = "</title></style><script>alert(1)</script><img src=x onerror=\"a'b\">&";

std::string analysis_with(const std::string& text) {
  return json{{"format", 1},
              {"quantities", {{"speed", {{"value", 1}, {"unit", "m/s"}, {"meaning", text}}}}},
              {"curves",
               {{"speed",
                 {{"kind", "measured"},
                  {"label", text},
                  {"x", {{"name", "time"}, {"unit", "s"}, {"values", {0, 1, 2}}}},
                  {"y",
                   {{"name", "speed"},
                    {"unit", "m/s"},
                    {"values", {1, nullptr, 3}},
                    {"error", {0.1, 0.1, 0.1}}}}}}}},
              {"figures",
               {{{"name", "speed"},
                 {"title", text},
                 {"caption", text},
                 {"panels",
                  {{{"title", text},
                    {"x_label", text},
                    {"y_scale", "log"},
                    {"curves", {"speed"}},
                    {"marks", {{{"axis", "y"}, {"value", 2}, {"label", text}}}}}}}}}}}
      .dump();
}

TEST_F(Page, NeedsAResult) {
  EXPECT_EQ(error_of([&] { page(); }).first, ExitCode::environment);
}

TEST_F(Page, IsWrittenFromAResultAlone) {
  write_result({}, folder_.path());
  const std::string html = page();
  EXPECT_TRUE(incomplete_.empty());
  EXPECT_THAT(html, HasSubstr("<p>Done.</p>"));
  for (const char* absent : {"<h2>Parameters", "<h2>Quantities", "<h2>Provenance", "<h2>Notes",
                             "<h2>Left out", "<h2>Run time", "<h2>Published", "<figure", "<pre>"}) {
    EXPECT_THAT(html, Not(HasSubstr(absent)));
  }
}

TEST_F(Page, ShowsWhatIsThere) {
  Result result;
  result.status = "failed";
  result.exit_code = 4;
  result.windows = 17;
  result.error = "participant 'grains' was killed";
  result.notes = {{"fluid", "inertia matters"}};
  result.left_out = {{"unit_answer", "fluid solve", "linear", 25.1}};
  write_result(result, folder_.path());
  folder_.write("workflow.json",
                R"({"name": "scene", "title": "A sphere", "description": "It falls.",
      "parameters": {"viscosity": {"shown": "1 Pa s"}, "density": {"shown": "2650 kg/m3", "overridden": true}}})");
  folder_.write("provenance.json",
                R"({"format": 1, "command": ["sandglass", "run", "a b.yaml"],
      "solvers": [{"name": "YADE", "version": "2023.02a", "digest": "0123456789abcdef0123"}],
      "timings": {"participants": {"fluid": 0.5}}, "peak_memory_bytes": {"fluid": 2e8}})");
  const std::string html = page();
  for (const char* present :
       {"<h1>A sphere</h1>", "It falls.", "Failed after 17 coupling windows.",
        "participant &#39;grains&#39; was killed", "inertia matters", "25.1\u00a0s",
        "2650\u00a0kg/m³", "set for this run", "sandglass run &#39;a b.yaml&#39;", "2023.02a",
        "0123456789ab", "0.5\u00a0s", "200\u00a0MB", "href=\"./provenance.json\""}) {
    EXPECT_THAT(html, HasSubstr(present));
  }
  EXPECT_THAT(html, Not(HasSubstr("0123456789abcdef")));
  EXPECT_LT(html.find("<code>viscosity"), html.find("<code>density")) << "in the workflow's order";
}

TEST_F(Page, DependsOnNothingElse) {
  write_result({}, folder_.path());
  const std::string html = page();
  for (const char* outside : {"http://", "https://", "<script", "<link", "@import", "url("}) {
    EXPECT_THAT(html, Not(HasSubstr(outside)));
  }
}

TEST_F(Page, HostileTextStaysText) {
  Result result;
  result.error = hostile;
  result.quantities["speed"] = {1.0, "m/s", hostile};
  result.notes = {{hostile, hostile}};
  ComparisonResult comparison;
  comparison.name = comparison.source = comparison.because = comparison.skipped = hostile;
  result.comparisons = {comparison};
  result.left_out = {{hostile, hostile, hostile, 1.0}};
  write_result(result, folder_.path());
  folder_.write("workflow.json", json{{"name", hostile},
                                      {"title", hostile},
                                      {"description", hostile},
                                      {"parameters", {{hostile, {{"shown", hostile}}}}}}
                                     .dump());
  folder_.write("provenance.json", json{{"command", {hostile}},
                                        {"host", {{"name", hostile}}},
                                        {"environment", {{hostile, hostile}}}}
                                       .dump());
  folder_.write("<b> x\"y", "a file of the run");
  const std::string html = page();
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, Not(HasSubstr("<img")));
  EXPECT_THAT(html, Not(HasSubstr("<b>")));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;"));
  EXPECT_THAT(html, HasSubstr("href=\"./%3Cb%3E%20x%22y\""));
}

TEST_F(Page, FiguresAreDrawnAndTheirTextStaysTextToo) {
  write_result({}, folder_.path());
  folder_.write("stages/analyse/analysis.json", analysis_with(std::string(hostile) + "$\\x{\x01"));
  const std::string html = page();
  EXPECT_THAT(incomplete_, testing::IsEmpty());
  EXPECT_THAT(html, HasSubstr("<svg"));
  EXPECT_THAT(html, HasSubstr("stroke: var(--series-1)"));
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, Not(HasSubstr("<img")));
  EXPECT_TRUE(std::filesystem::exists(folder_.path() + "/figures/speed.png"));
  const std::string drawn = read_file(folder_.path() + "/figures/speed.svg");
  std::filesystem::remove_all(folder_.path() + "/figures");
  page();
  EXPECT_EQ(read_file(folder_.path() + "/figures/speed.svg"), drawn) << "the same every time";
}

TEST_F(Page, WhatCannotBeShownIsSaidAndTheRestIsShown) {
  Result result;
  result.notes = {{"", "still here"}};
  write_result(result, folder_.path());
  folder_.write("workflow.json", "{");
  folder_.write("provenance.json",
                R"({"host": 7, "solvers": "none", "timings": [1], "command": {}})");
  folder_.write("stages/analyse/analysis.json", "{}");
  const std::string html = page();
  EXPECT_EQ(incomplete_.size(), 2U);
  EXPECT_THAT(html, HasSubstr("Not shown: workflow.json cannot be read"));
  EXPECT_THAT(html, HasSubstr("Not shown: the figures: analysis stage"));
  EXPECT_THAT(html, HasSubstr("still here"));
}

TEST_F(Page, ADrawingThatFailsCostsTheFiguresOnly) {
  write_result({}, folder_.path());
  folder_.write("stages/analyse/analysis.json", analysis_with("speed"));
  tools_.python = "/bin/false";
  EXPECT_THAT(page(), HasSubstr("Not shown: the figures: drawing of the figures"));
}

}  // namespace
}  // namespace sandglass::report
