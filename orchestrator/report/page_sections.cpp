#include "report/page_sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/unit.hpp"
#include "report/format.hpp"

namespace sandglass::report {
namespace {

using json = nlohmann::ordered_json;

const json& at(const json& object, const char* key) {
  static const json nothing;
  if (!object.is_object()) return nothing;
  const auto found = object.find(key);
  return found == object.end() ? nothing : *found;
}

Value::List list_of(const std::string& text) {
  return text.empty() ? Value::List{} : Value::List{text};
}

/// Long enough to tell two files apart, short enough to read.
std::string short_digest(const std::string& digest) { return digest.substr(0, 12); }

std::string plural(std::int64_t count, const std::string& thing) {
  return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

bool is_ratio(const ComparisonResult& comparison) {
  return comparison.metric == "relative difference";
}

std::string shown_value(const ComparisonResult& comparison, double value) {
  return is_ratio(comparison) ? pretty_percent(value)
                              : pretty_quantity(value, comparison.shown_in, 3);
}

std::string number_or_dash(const ComparisonResult& comparison, const std::optional<double>& value) {
  return value ? pretty_quantity(*value, comparison.shown_in, 6) : std::string("–");
}

/// "2650 kg/m3" with its unit set as in print; other text as it is.
std::string with_pretty_unit(const std::string& text) {
  const size_t space = text.find(' ');
  Quantity quantity;
  if (space == std::string::npos || !Quantity::parse(text, quantity)) return text;
  return text.substr(0, space) + "\u00a0" + pretty_unit(text.substr(space + 1));
}

Value::Map comparison_row(const ComparisonResult& comparison) {
  Value::List details;
  if (!comparison.source.empty())
    details.push_back("Reference: " + comparison.source);
  else if (!comparison.against.empty())
    details.push_back("Against: " + comparison.against);
  if (comparison.points) {
    details.push_back(fmt::format("{}, abscissa {} to {}", plural(*comparison.points, "point"),
                                  pretty_number(comparison.from, 4),
                                  pretty_number(comparison.to, 4)));
  }
  if (!comparison.because.empty()) details.push_back("Tolerance: " + comparison.because);
  std::string colour = "calm";
  std::string outcome = "skipped";
  if (comparison.passed) {
    colour = *comparison.passed ? "good" : "bad";
    outcome = *comparison.passed ? "✓ within" : "✗ outside";
  }
  const bool of_curves = comparison.points.has_value();
  return {{"name", comparison.name},
          {"details", std::move(details)},
          {"reference", of_curves ? "curve" : number_or_dash(comparison, comparison.reference)},
          {"ours", of_curves ? "curve" : number_or_dash(comparison, comparison.ours)},
          {"value", comparison.value ? shown_value(comparison, *comparison.value) : "–"},
          {"metric", comparison.metric == "value" ? "the value itself" : comparison.metric},
          {"tolerance", shown_value(comparison, comparison.tolerance)},
          {"class", colour},
          {"outcome", outcome},
          {"why", list_of(comparison.skipped)}};
}

/// A list shows its first values and how many there are; lists in it stand in brackets.
std::string shown_list(const Value::List& list) {
  std::string text;
  constexpr size_t most = 4;
  for (size_t i = 0; i < std::min(most, list.size()); ++i) {
    if (i > 0) text += ", ";
    if (const double* number = list[i].as<double>()) {
      text += pretty_number(*number, 4);
    } else if (const Value::List* inner = list[i].as<Value::List>()) {
      text += "[" + shown_list(*inner) + "]";
    } else {
      text += "…";
    }
  }
  if (list.size() > most) text += fmt::format(", … ({} values)", list.size());
  return text;
}

std::string shown_quantity(const Value& value, const std::string& unit) {
  if (value.absent()) return "not defined";
  if (const double* number = value.as<double>()) return pretty_quantity(*number, unit);
  const Value::List* list = value.as<Value::List>();
  if (list == nullptr) return {};
  const std::string text = shown_list(*list);
  const std::string shown = pretty_unit(unit);
  return shown.empty() ? text : text + "\u00a0" + shown;
}

void add_fact(Value::List& facts, const std::string& name, const std::string& text) {
  if (!text.empty()) facts.push_back(Value::Map{{"name", name}, {"text", text}});
}

/// An argument vector as one line to read; not meant for a shell.
std::string joined(const json& command) {
  std::string text;
  if (!command.is_array()) return text;
  for (const json& word : command) {
    if (!word.is_string()) continue;
    const std::string argument = word.get<std::string>();
    const bool plain = !argument.empty() && argument.find_first_of(" \t\n\"'") == std::string::npos;
    text += (text.empty() ? "" : " ") + (plain ? argument : "'" + argument + "'");
  }
  return text;
}

/// One table of files or settings: the columns named, and the digest at the end.
void add_table(Value::List& tables, const std::string& title, const json& items,
               std::initializer_list<const char*> columns) {
  Value::List rows;
  for (const json& item : items) {
    Value::List cells;
    for (const char* column : columns) cells.push_back(text_at(item, column));
    rows.push_back(
        Value::Map{{"cells", std::move(cells)}, {"digest", short_digest(text_at(item, "digest"))}});
  }
  if (rows.empty()) return;
  const auto count = static_cast<std::int64_t>(rows.size());
  tables.push_back(Value::Map{{"title", title}, {"count", count}, {"rows", std::move(rows)}});
}

}  // namespace

std::string text_at(const json& object, const char* key) {
  const json& value = at(object, key);
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_integer()) return std::to_string(value.get<std::int64_t>());
  if (value.is_number()) return pretty_number(value.get<double>());
  if (value.is_boolean()) return value.get<bool>() ? "true" : "false";
  return {};
}

Banner banner_of(const Result& result) {
  std::int64_t passed = 0;
  std::int64_t skipped = 0;
  std::vector<std::string> outside;
  for (const ComparisonResult& comparison : result.comparisons) {
    if (!comparison.passed)
      ++skipped;
    else if (*comparison.passed)
      ++passed;
    else
      outside.push_back("“" + comparison.name + "”");
  }
  const std::string windows = plural(result.windows, "coupling window");
  const std::string time =
      result.wall_time_s ? " in " + pretty_seconds(*result.wall_time_s) : std::string();
  const std::string skips =
      skipped == 0 ? ""
                   : fmt::format(", {} skipped because it does not apply to this run", skipped);
  if (result.status == "done") {
    // A study's summary has no windows of its own.
    std::string sentence =
        result.windows > 0 ? fmt::format("Done: {}{}", windows, time) : "Done" + time;
    if (passed == 1) sentence += "; the one comparison made is within tolerance";
    if (passed > 1)
      sentence += fmt::format("; all {} comparisons made are within tolerance", passed);
    return {"good", "✓", sentence + skips + "."};
  }
  if (result.status == "mismatch") {
    std::string names;
    for (const std::string& name : outside) names += (names.empty() ? "" : ", ") + name;
    return {"bad", "✗",
            fmt::format("Done{}, but {} of {} comparisons made {} out of tolerance: {}{}.", time,
                        outside.size(), outside.size() + static_cast<size_t>(passed),
                        outside.size() == 1 ? "is" : "are", names, skips)};
  }
  if (result.status == "interrupted") {
    return {"calm", "–", fmt::format("Interrupted by the user after {}.", windows)};
  }
  const std::string how = result.status == "unstable"      ? "Numerically unstable"
                          : result.status == "environment" ? "Stopped by the environment"
                          : result.status == "refused"     ? "Refused"
                                                           : "Failed";
  return {"bad", "✗", fmt::format("{} after {}.", how, windows)};
}

Value::List comparison_rows(const Result& result) {
  Value::List rows;
  for (const ComparisonResult& comparison : result.comparisons) {
    rows.push_back(comparison_row(comparison));
  }
  return rows;
}

namespace {

const json& points_of(const json& study) {
  static const json none = json::array();
  const json& points = at(study, "points");
  return points.is_array() ? points : none;
}

/// "as expected: unstable" and the like.
std::string outcome_text(const json& point) {
  const std::string status = text_at(point, "status");
  const bool good = point.value("good", false);
  if (status.empty()) return "no result";
  if (status == "mismatch" && good) return "out of tolerance";
  return good && status != "done" ? status + ", as expected" : status;
}

}  // namespace

std::string points_summary(const json& study) {
  std::size_t good = 0;
  std::size_t outside = 0;
  for (const json& point : points_of(study)) {
    if (point.value("good", false)) ++good;
    if (point.value("good", false) && text_at(point, "status") == "mismatch") ++outside;
  }
  const std::size_t all = points_of(study).size();
  if (all == 0) return {};
  std::string text =
      fmt::format("{}: {} as expected", plural(static_cast<std::int64_t>(all), "point"), good);
  if (good < all) text += fmt::format(", {} otherwise", all - good);
  if (outside > 0)
    text += fmt::format("; {} of them out of the workflow's own tolerances", outside);
  return text + ".";
}

Value::List point_rows(const json& study) {
  Value::List rows;
  for (const json& point : points_of(study)) {
    const bool good = point.value("good", false);
    const json& seconds = at(at(point, "seconds"), "run");
    rows.push_back(
        Value::Map{{"label", text_at(point, "label")},
                   {"set", list_of(text_at(point, "set"))},
                   {"outcome", outcome_text(point)},
                   {"class", !good                                ? "bad"
                             : text_at(point, "status") == "done" ? "good"
                                                                  : "calm"},
                   {"windows", std::to_string(point.value("windows", std::int64_t{0}))},
                   {"seconds", seconds.is_number() ? pretty_seconds(seconds.get<double>())
                                                   : std::string("–")}});
  }
  return rows;
}

Value::List quantity_rows(const Result& result) {
  Value::List rows;
  for (const auto& [name, quantity] : result.quantities) {
    rows.push_back(Value::Map{{"name", name},
                              {"value", shown_quantity(quantity.value, quantity.unit)},
                              {"meaning", quantity.meaning}});
  }
  return rows;
}

Value::List parameter_rows(const json& workflow) {
  Value::List rows;
  const json& parameters = at(workflow, "parameters");
  if (!parameters.is_object()) return rows;
  for (const auto& item : parameters.items()) {
    const json& parameter = item.value();
    const bool changed = at(parameter, "overridden") == true;
    std::string shown = with_pretty_unit(text_at(parameter, "shown"));
    if (shown.empty()) {
      shown = text_at(parameter, "value");
      const std::string unit = pretty_unit(text_at(parameter, "unit"));
      if (!unit.empty()) shown += "\u00a0" + unit;
    }
    rows.push_back(Value::Map{{"name", item.key()},
                              {"value", shown},
                              {"changed", changed},
                              {"class", changed ? "set" : "as-given"},
                              {"meaning", text_at(parameter, "meaning")},
                              {"source", text_at(parameter, "source")}});
  }
  return rows;
}

std::string time_summary(const Result& result) {
  if (!result.wall_time_s) return {};
  std::string text = pretty_seconds(*result.wall_time_s) + " of wall time";
  if (result.windows > 0) text += " for " + plural(result.windows, "window");
  if (result.overhead_s_per_window && std::isfinite(*result.overhead_s_per_window)) {
    text += fmt::format(
        "; the coupling itself took {} per window beside what the participants computed",
        pretty_seconds(*result.overhead_s_per_window));
  }
  return text + ".";
}

Value::List time_rows(const Result& result, const json& provenance) {
  const json& timings = at(provenance, "timings");
  const json& memory = at(provenance, "peak_memory_bytes");
  std::vector<std::pair<std::string, double>> parts;
  std::vector<std::string> peaks;
  const auto add = [&](const std::string& name, const json& seconds, const std::string& of) {
    if (!seconds.is_number() || !std::isfinite(seconds.get<double>())) return;
    parts.emplace_back(name, seconds.get<double>());
    const json& peak = of.empty() ? json() : at(memory, of.c_str());
    peaks.push_back(peak.is_number() ? pretty_bytes(peak.get<double>()) : std::string());
  };
  add("start of the participants", at(timings, "start"), "");
  if (at(timings, "participants").is_object()) {
    for (const auto& [name, seconds] : at(timings, "participants").items()) {
      add(name, seconds, name);
    }
  }
  add("exchange of fields", at(timings, "exchange"), "");
  add("rendering of scripts", at(timings, "render"), "");
  add("orchestrator", at(timings, "orchestrator"), "orchestrator");
  if (at(timings, "stages").is_object()) {
    for (const auto& [name, seconds] : at(timings, "stages").items()) {
      add("stage " + name, seconds, name);
    }
  }
  add("report", at(timings, "report"), "");
  double whole = result.wall_time_s.value_or(0);
  for (const auto& [name, seconds] : parts) whole = std::max(whole, seconds);
  Value::List rows;
  for (size_t i = 0; i < parts.size(); ++i) {
    const auto& [name, seconds] = parts[i];
    const double share = whole > 0 ? 100 * seconds / whole : 0;
    const bool not_yet = name == "report" && seconds == 0;  // the page is written before
    rows.push_back(Value::Map{{"name", name},
                              {"seconds", not_yet ? "not yet known" : pretty_seconds(seconds)},
                              {"share", fmt::format("{:.2f}", std::clamp(share, 0.0, 100.0))},
                              {"memory", peaks[i]}});
  }
  return rows;
}

Value::List saving_rows(const Result& result) {
  Value::List rows;
  for (const Saving& saving : result.left_out) {
    rows.push_back(
        Value::Map{{"what", saving.what},
                   {"why", saving.why},
                   {"saving", saving.saving_s ? pretty_seconds(*saving.saving_s) : "not known"}});
  }
  return rows;
}

Value::List note_rows(const Result& result) {
  Value::List rows;
  for (const Note& note : result.notes) {
    rows.push_back(Value::Map{{"text", note.text}, {"from", list_of(note.from)}});
  }
  return rows;
}

Value::List provenance_facts(const json& provenance) {
  Value::List facts;
  add_fact(facts, "Started", text_at(provenance, "started"));
  add_fact(facts, "Command", joined(at(provenance, "command")));
  const json& program = at(provenance, "program");
  std::string version = text_at(program, "version");
  const std::string digest = text_at(program, "digest");
  if (!digest.empty()) version += fmt::format(" (digest {})", short_digest(digest));
  add_fact(facts, "Sandglass", version);
  for (const json& solver : at(provenance, "solvers")) {
    const std::string found = text_at(solver, "digest");
    add_fact(facts, text_at(solver, "name"),
             text_at(solver, "version") +
                 (found.empty() ? "" : fmt::format(" (digest {})", short_digest(found))));
  }
  const json& host = at(provenance, "host");
  std::string machine = text_at(host, "processor");
  if (!text_at(host, "cores").empty()) machine += fmt::format(", {} cores", text_at(host, "cores"));
  if (at(host, "memory_bytes").is_number()) {
    machine += ", " + pretty_bytes(at(host, "memory_bytes").get<double>());
  }
  if (machine.starts_with(", ")) machine.erase(0, 2);
  add_fact(facts, "Machine", machine);
  add_fact(facts, "Host", text_at(host, "name"));
  add_fact(facts, "System", text_at(host, "system"));
  const json& seeds = at(provenance, "seeds");
  if (seeds.is_object()) {
    std::string text;
    for (const auto& item : seeds.items()) {
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", item.key(),
                          text_at(seeds, item.key().c_str()));
    }
    add_fact(facts, "Seeds", text);
  }
  return facts;
}

Value::List provenance_tables(const json& provenance) {
  Value::List tables;
  json programs = json::array();
  for (const json& solver : at(provenance, "solvers")) {
    programs.push_back(solver);
    for (const json& part : at(solver, "parts")) programs.push_back(part);
  }
  add_table(tables, "Solvers", programs, {"name", "version", "path"});
  add_table(tables, "Templates", at(provenance, "templates"), {"path"});
  add_table(tables, "Rendered scripts", at(provenance, "scripts"), {"participant", "path"});
  add_table(tables, "Data", at(provenance, "data"), {"path"});
  json settings = json::array();
  const json& environment = at(provenance, "environment");
  if (environment.is_object()) {
    for (const auto& item : environment.items()) {
      settings.push_back(
          {{"name", item.key()}, {"value", text_at(environment, item.key().c_str())}});
    }
  }
  add_table(tables, "Environment", settings, {"name", "value"});
  return tables;
}

}  // namespace sandglass::report
