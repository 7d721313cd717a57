#include "report/page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/clock.hpp"
#include "base/file.hpp"
#include "record/crate.hpp"
#include "render/template.hpp"
#include "report/page_sections.hpp"

namespace sandglass::report {
namespace {

using json = nlohmann::ordered_json;  // parameters stay in the order of the workflow
namespace fs = std::filesystem;

/// null when the file is missing; what is wrong with it goes to `incomplete`.
json read_optional(const std::string& run_directory, const std::string& name,
                   std::vector<std::string>& incomplete) {
  const std::string path = run_directory + "/" + name;
  std::error_code error;
  if (!fs::exists(path, error)) return {};
  try {
    return json::parse(read_file(path));
  } catch (const json::exception& problem) {
    incomplete.push_back(fmt::format("{} cannot be read: {}", name, problem.what()));
  } catch (const Error& problem) {
    incomplete.push_back(fmt::format("{} cannot be read: {}", name, problem.what()));
  }
  return {};
}

Analysis draw_all(const std::string& run_directory, const ReportTools& tools,
                  std::vector<std::string>& incomplete) {
  // A run that failed in its analysis must still have a report.
  try {
    Analysis analysis = read_analyses(run_directory, analysed_stages(run_directory));
    draw_figures(analysis, run_directory, tools);
    return analysis;
  } catch (const Error& problem) {
    if (problem.code() == ExitCode::interrupted) throw;
    incomplete.push_back(fmt::format("the figures: {}", problem.what()));
  }
  return {};
}

Value::List list_of(const std::string& text) {
  return text.empty() ? Value::List{} : Value::List{text};
}

/// A path below the run directory as a link.
std::string href(const std::string& path) {
  static const std::string plain = "-_.~/";
  std::string text;
  for (const char c : path) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (letter || plain.find(c) != std::string::npos)
      text += c;
    else
      text += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return "./" + text;
}

Value::List figure_values(const Analysis& analysis, const std::string& run_directory) {
  Value::List figures;
  for (const Figure& figure : analysis.figures) {
    const std::string base = "figures/" + figure.name;
    const std::string drawing = read_file(run_directory + "/" + base + ".svg");
    figures.push_back(Value::Map{{"anchor", "figure-" + figure.name},
                                 {"has_title", !figure.title.empty()},
                                 {"title", figure.title},
                                 {"caption", figure.caption},
                                 {"svg", Value::Markup{drawing}},
                                 {"svg_file", href(base + ".svg")},
                                 {"png_file", href(base + ".png")}});
  }
  return figures;
}

Value::List table_values(const Analysis& analysis) {
  Value::List tables;
  for (const Table& table : analysis.tables) {
    Value::List rows;
    for (const auto& texts : table.rows) {
      constexpr std::size_t number = 16;  // characters: as long as one with its unit is
      Value::List cells;
      for (const std::string& text : texts) {
        cells.push_back(
            Value::Map{{"text", text}, {"class", text.size() <= number ? "short" : ""}});
      }
      rows.push_back(Value::Map{{"cells", std::move(cells)}});
    }
    tables.push_back(
        Value::Map{{"table_title", table.title},
                   {"caption", list_of(table.caption)},
                   {"columns", Value::List(table.columns.begin(), table.columns.end())},
                   {"rows", std::move(rows)}});
  }
  return tables;
}

/// What lies in the run directory, and the stages' own files, to open. The crate is written when
/// the page is there, whose digest it holds.
Value::List file_values(const std::string& run_directory) {
  std::vector<std::string> names = {record::kCrateFile};
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(run_directory, error)) {
    const std::string name = entry.path().filename().string();
    if (name.front() == '.' || name == "report.html" || name == "lock") continue;
    if (name.ends_with(".part") || name == record::kCrateFile) continue;
    names.push_back(entry.is_directory(error) ? name + "/" : name);
  }
  for (const std::string& stage : analysed_stages(run_directory)) {
    names.push_back("stages/" + stage + "/analysis.json");
  }
  std::sort(names.begin(), names.end());
  Value::List files;
  for (const std::string& name : names) {
    files.push_back(Value::Map{{"name", name}, {"href", href(name)}});
  }
  return files;
}

void add_section(Value::Map& values, const std::string& name, Value::List rows) {
  values["has_" + name] = !rows.empty();
  values[name] = std::move(rows);
}

}  // namespace

std::vector<std::string> write_report(const std::string& run_directory, const ReportTools& tools) {
  std::vector<std::string> incomplete;
  const Result result = read_result(run_directory);
  const json workflow = read_optional(run_directory, "workflow.json", incomplete);
  const json provenance = read_optional(run_directory, "provenance.json", incomplete);
  const Analysis analysis = draw_all(run_directory, tools, incomplete);

  std::string name = text_at(workflow, "name");
  if (name.empty()) name = fs::path(run_directory).lexically_normal().filename().string();
  std::string title = text_at(workflow, "title");
  if (title.empty()) title = name;
  const std::string started = text_at(provenance, "started");

  Value::Map values;
  values["title"] = title;
  values["kicker"] = started.empty() ? name : fmt::format("{} · {}", name, started.substr(0, 10));
  values["description"] = list_of(text_at(workflow, "description"));
  const Banner banner = banner_of(result);
  values["banner_class"] = banner.colour;
  values["banner_sign"] = banner.sign;
  values["banner"] = banner.sentence;
  values["error"] = list_of(result.error);
  values["figures"] = figure_values(analysis, run_directory);
  values["tables"] = table_values(analysis);
  const json study = read_optional(run_directory, "points.json", incomplete);
  values["points_summary"] = list_of(points_summary(study));
  add_section(values, "points", point_rows(study));
  add_section(values, "comparisons", comparison_rows(result));
  add_section(values, "quantities", quantity_rows(result));
  add_section(values, "parameters", parameter_rows(workflow));
  const Value::List times = time_rows(result, provenance);
  values["has_times"] = result.wall_time_s.has_value() || !times.empty();
  values["has_time_rows"] = !times.empty();
  values["time_summary"] = list_of(time_summary(result));
  values["times"] = times;
  add_section(values, "left_out", saving_rows(result));
  add_section(values, "notes", note_rows(result));
  values["has_provenance"] = provenance.is_object() && !provenance.empty();
  values["facts"] = provenance_facts(provenance);
  values["provenance_tables"] = provenance_tables(provenance);
  values["files"] = file_values(run_directory);
  values["footer"] = "Written by Sandglass " + date_and_time().substr(0, 10) +
                     " from the files of the run directory.";
  values["incomplete"] = Value::List(incomplete.begin(), incomplete.end());

  const Template page = Template::load(tools.templates_root, "report/report.html");
  write_file(run_directory + "/report.html", page.render(values));
  return incomplete;
}

}  // namespace sandglass::report
