#include "study/points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/error.hpp"
#include "base/file.hpp"

namespace sandglass::study {
namespace {

using workflow::Setting;
using Settings = std::vector<Setting>;

constexpr std::size_t most_points = 10'000;
constexpr std::size_t longest_name = 120;

/// Every combination of one value per axis.
std::vector<Settings> combinations(const std::vector<Settings>& axes, const Place& place) {
  std::vector<Settings> all{{}};
  for (const Settings& axis : axes) {
    if (all.size() * axis.size() > most_points) {
      throw Error::refused(place, fmt::format("more than {} points", most_points),
                           "sweep fewer values, or split the study");
    }
    std::vector<Settings> longer;
    for (const Settings& before : all) {
      for (const Setting& value : axis) {
        longer.push_back(before);
        longer.back().push_back(value);
      }
    }
    all = std::move(longer);
  }
  return all;
}

/// Later settings win over earlier ones of the same parameter.
void put(Settings& settings, const Setting& setting) {
  const auto same = [&](const Setting& other) { return other.name == setting.name; };
  const auto found = std::find_if(settings.begin(), settings.end(), same);
  if (found == settings.end())
    settings.push_back(setting);
  else
    *found = setting;
}

void put(Settings& settings, const Settings& added) {
  for (const Setting& setting : added) put(settings, setting);
}

std::string label_of(const Settings& settings) {
  std::string label;
  for (const Setting& one : settings) {
    label += fmt::format("{}{}={}", label.empty() ? "" : ", ", one.name, one.text);
  }
  return label;
}

/// Fit for a folder: "scheme=serial-explicit,window=1ms".
std::string folder_name(const std::string& label) {
  std::string name;
  for (const char c : label) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (c == ' ') continue;
    name += plain || std::string_view("_-+.,=").find(c) != std::string_view::npos ? c : '_';
  }
  if (name.empty()) return "point";
  if (name.front() == '.' || name.front() == '-') name.insert(0, 1, '_');
  if (name.size() <= longest_name) return name;
  constexpr std::size_t digits = 12;
  return name.substr(0, longest_name - digits - 1) + "-" + digest_of_text(label).substr(0, digits);
}

void add_set(std::vector<Point>& points, const workflow::Study& study,
             const workflow::StudyPoints& set, const Settings& command_line) {
  const std::vector<Settings> grid = combinations(set.grid, set.place);
  const std::vector<Settings> seeds = combinations(set.seeds, set.place);
  const std::vector<Settings> list = set.list.empty() ? std::vector<Settings>{{}} : set.list;
  const auto count = list.size() * grid.size() * seeds.size();
  if (points.size() + count * static_cast<std::size_t>(std::min<std::int64_t>(
                                  set.repeat, static_cast<std::int64_t>(most_points))) >
      most_points) {
    throw Error::refused(set.place, fmt::format("more than {} points", most_points),
                         "sweep fewer values, or split the study");
  }
  for (const Settings& item : list) {
    for (const Settings& values : grid) {
      for (const Settings& seed : seeds) {
        for (std::int64_t repetition = 1; repetition <= set.repeat; ++repetition) {
          Point point;
          point.set = set.name;
          point.unstable = set.unstable;
          point.repetition = repetition;
          Settings own = set.set;
          put(own, item);
          put(own, values);
          point.sample_of = label_of(own);
          put(own, seed);
          point.label = label_of(own);
          if (set.repeat > 1) {
            point.label += fmt::format("{}repetition {}", own.empty() ? "" : ", ", repetition);
          }
          if (point.label.empty()) point.label = set.name.empty() ? "as it is" : set.name;
          point.name = folder_name(point.label);
          point.settings = study.set;
          put(point.settings, command_line);
          put(point.settings, own);
          points.push_back(std::move(point));
        }
      }
    }
  }
}

void check_command_line(const workflow::Study& study, const Settings& command_line) {
  const auto swept = [&](const Settings& settings, const std::string& name) {
    return std::any_of(settings.begin(), settings.end(),
                       [&](const Setting& one) { return one.name == name; });
  };
  for (const Setting& setting : command_line) {
    for (const workflow::StudyPoints& set : study.points) {
      bool found = swept(set.set, setting.name);
      for (const auto* axes : {&set.list, &set.grid, &set.seeds}) {
        for (const Settings& axis : *axes) found = found || swept(axis, setting.name);
      }
      if (!found) continue;
      throw Error::usage(fmt::format("--set {}: the study sets this parameter itself ({})",
                                     setting.name, set.place.text()),
                         "change it there, or run the workflow alone");
    }
  }
}

}  // namespace

std::vector<Point> make_points(const workflow::Study& study, const Settings& command_line) {
  check_command_line(study, command_line);
  std::vector<Point> points;
  for (const workflow::StudyPoints& set : study.points) {
    add_set(points, study, set, command_line);
  }
  std::map<std::string, const Point*> known;
  for (Point& point : points) {
    const auto [other, is_new] = known.emplace(point.name, &point);
    if (is_new) continue;
    if (other->second->label == point.label && other->second->set == point.set) {
      throw Error::refused(
          study.place, fmt::format("the point '{}' stands here twice", point.label), "remove one");
    }
    // Two names that only look alike in a folder, or the same point in two sets.
    point.name += "-" + digest_of_text(point.set + "\n" + point.label).substr(0, 8);
    known.emplace(point.name, &point);
  }
  return points;
}

}  // namespace sandglass::study
