#include "report/analysis.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "report/figures.hpp"
#include "support.hpp"

namespace sandglass::report {
namespace {

using nlohmann::json;
using testing::HasSubstr;

json axis(const std::string& name, const std::string& unit, json values) {
  return {{"name", name}, {"unit", unit}, {"values", std::move(values)}};
}

json good() {
  return {{"format", 1},
          {"quantities",
           {{"speed", {{"value", 0.5}, {"unit", "m/s"}, {"meaning", "at the end"}}},
            {"table", {{"value", {{1, 2}, {3, nullptr}}}, {"unit", "1"}}},
            {"box", {{"value", nullptr}, {"unit", "1"}}},
            {"wrong", {{"value", "nan"}, {"unit", "Pa"}}}}},
          {"curves",
           {{"velocity",
             {{"kind", "computed"},
              {"label", "ours"},
              {"x", axis("time", "s", {0, 0.5})},
              {"y", axis("velocity", "m/s", {nullptr, 2})},
              {"file", "velocity.csv"}}}}},
          {"figures",
           {{{"name", "figure_2"},
             {"title", "Velocity"},
             {"panels",
              {{{"x_unit", "ms"},
                {"y_unit", "mm/s"},
                {"y_scale", "log"},
                {"curves", {"velocity"}},
                {"marks", {{{"axis", "x"}, {"value", 0.25}, {"label", "here"}}}}}}}}}}};
}

class ReadAnalysis : public testing::Test {
 protected:
  Analysis read(const json& document) {
    return read_analysis(folder_.write("analysis.json", document.dump()), "analyse");
  }
  std::string text_of(const json& document) {
    const auto [code, text] = error_of([&] { read(document); });
    EXPECT_EQ(code, ExitCode::participant);
    EXPECT_THAT(text, HasSubstr("analysis stage 'analyse'"));
    return text;
  }
  Folder folder_;
};

TEST_F(ReadAnalysis, TakesEverything) {
  const Analysis analysis = read(good());
  EXPECT_EQ(*analysis.quantities.at("speed").value.as<double>(), 0.5);
  EXPECT_EQ(analysis.quantities.at("speed").unit, "m/s");
  EXPECT_TRUE(analysis.quantities.at("box").value.absent());
  EXPECT_TRUE(std::isnan(*analysis.quantities.at("wrong").value.as<double>()))
      << "not finite is something else than not defined";
  const Value::List& rows = *analysis.quantities.at("table").value.as<Value::List>();
  EXPECT_EQ(*rows.at(1).as<Value::List>()->at(0).as<double>(), 3.0);
  const Curve& curve = analysis.curves.at("velocity");
  EXPECT_TRUE(std::isnan(curve.y.values.at(0)));
  EXPECT_EQ(curve.y.values.at(1), 2.0);
  const Panel& panel = analysis.figures.at(0).panels.at(0);
  EXPECT_EQ(panel.x_label, "time") << "of the curve, when the panel gives none";
  EXPECT_FALSE(panel.x_logarithmic);
  EXPECT_TRUE(panel.y_logarithmic);
}

TEST_F(ReadAnalysis, FiguresAreDrawnInTheUnitsOfTheirPanels) {
  const json drawn = json::parse(figures_to_json(read(good())));
  const json& panel = drawn.at("figures").at(0).at("panels").at(0);
  EXPECT_EQ(panel.at("x_label"), "time (ms)");
  EXPECT_EQ(panel.at("y_label"), "velocity (mm/s)");
  EXPECT_NEAR(panel.at("curves").at(0).at("x").at(1).get<double>(), 500.0, 1e-9);
  EXPECT_TRUE(panel.at("curves").at(0).at("y").at(0).is_null());
  EXPECT_NEAR(panel.at("curves").at(0).at("y").at(1).get<double>(), 2000.0, 1e-9);
  EXPECT_NEAR(panel.at("marks").at(0).at("value").get<double>(), 250.0, 1e-9);
}

TEST_F(ReadAnalysis, SaysWhereAndWhat) {
  const auto with = [](const char* pointer, json value) {
    json document = good();
    document[json::json_pointer(pointer)] = std::move(value);
    return document;
  };
  EXPECT_THAT(text_of(with("/format", 2)), HasSubstr("format 2 is not known"));
  EXPECT_THAT(text_of(with("/quantities/speed/value", "fast")),
              HasSubstr("quantities.speed.value: must be a number"));
  EXPECT_THAT(text_of(with("/quantities/speed/unit", "mm/s")),
              HasSubstr("quantities.speed.unit: 'mm/s' is not an SI unit"));
  EXPECT_THAT(text_of(with("/quantities/speed/unit", "parsnip")),
              HasSubstr("'parsnip' is not a unit"));
  EXPECT_THAT(text_of(with("/curves/velocity/kind", "compute")),
              HasSubstr("did you mean 'computed'?"));
  EXPECT_THAT(text_of(with("/curves/velocity/x/values", {1, 2, 3})),
              HasSubstr("curves.velocity: 3 abscissae and 2 ordinates"));
  EXPECT_THAT(text_of(with("/curves/velocity/x/values", 7)),
              HasSubstr("curves.velocity.x.values: must be a list of numbers"));
  EXPECT_THAT(text_of(with("/curves/velocity/file", "../../secret")),
              HasSubstr("in the stage's own work directory"));
  EXPECT_THAT(text_of(with("/figures/0/name", "../x")), HasSubstr("'../x' is not a name"));
  EXPECT_THAT(text_of(with("/figures/0/panels/0/curves/0", "velocty")),
              HasSubstr("figures[0].panels[0].curves[0]: the analysis has no curve 'velocty'; did "
                        "you mean 'velocity'?"));
  EXPECT_THAT(text_of(with("/figures/0/panels/0/x_unit", "Pa")),
              HasSubstr("a curve in 's' cannot be drawn in 'Pa'"));
  EXPECT_THAT(text_of(with("/figures/0/panels/0/y_scal", "log")),
              HasSubstr("unknown key 'y_scal'; did you mean 'y_scale'?"));
  EXPECT_THAT(text_of(with("/figures/0/panels", json::array())), HasSubstr("at least one panel"));
  json lacking = good();
  lacking.at("curves").at("velocity").erase("y");
  EXPECT_THAT(text_of(lacking), HasSubstr("curves.velocity: 'y' is missing"));
  EXPECT_THAT(text_of(json::array()), HasSubstr("must be a map"));
}

TEST_F(ReadAnalysis, RefusesWhatIsNotJson) {
  const std::string path =
      folder_.write("analysis.json", R"({"format": 1, "quantities": {"a": NaN)");
  const auto [code, text] = error_of([&] { read_analysis(path, "analyse"); });
  EXPECT_EQ(code, ExitCode::participant);
  EXPECT_THAT(text, HasSubstr("is not JSON"));
  EXPECT_EQ(error_of([&] { read_analysis(path + "x", "analyse"); }).first, ExitCode::environment);
}

TEST_F(ReadAnalysis, TwoStagesCannotDefineTheSameName) {
  folder_.write("stages/first/analysis.json", good().dump());
  json second = good();
  folder_.write("stages/second/analysis.json", second.dump());
  EXPECT_EQ(analysed_stages(folder_.path()), (std::vector<std::string>{"first", "second"}));
  const auto [code, text] =
      error_of([&] { read_analyses(folder_.path(), analysed_stages(folder_.path())); });
  EXPECT_EQ(code, ExitCode::participant);
  EXPECT_THAT(text, HasSubstr("analysis stages 'first' and 'second' both define the quantity"));
  EXPECT_EQ(read_analyses(folder_.path(), {"second"}).curves.at("velocity").stage, "second");
}

TEST(Thin, KeepsTheEndsAndTheExtremes) {
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 0; i < 100000; ++i) {
    x.push_back(i);
    y.push_back(i == 54321 ? 100.0 : i == 777 ? -100.0 : std::sin(0.001 * i));
  }
  thin(x, y, 1000);
  EXPECT_LE(x.size(), 1002U);
  EXPECT_EQ(x.size(), y.size());
  EXPECT_EQ(x.front(), 0.0);
  EXPECT_EQ(x.back(), 99999.0);
  EXPECT_TRUE(std::is_sorted(x.begin(), x.end()));
  EXPECT_EQ(*std::max_element(y.begin(), y.end()), 100.0);
  EXPECT_EQ(*std::min_element(y.begin(), y.end()), -100.0);
}

}  // namespace
}  // namespace sandglass::report
