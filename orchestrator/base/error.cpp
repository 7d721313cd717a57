#include "base/error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace sandglass {
namespace {

std::string join_texts(const std::vector<Problem>& problems) {
  std::string all;
  for (const Problem& problem : problems) {
    if (!all.empty()) all += '\n';
    all += problem.text();
  }
  return all;
}

size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row[b.size()];
}

}  // namespace

std::string Place::text() const {
  if (line == 0) return file;
  if (column == 0) return fmt::format("{}:{}", file, line);
  return fmt::format("{}:{}:{}", file, line, column);
}

std::string Problem::text() const {
  std::string all = place.file.empty() ? what : place.text() + ": " + what;
  if (!remedy.empty()) all += "; " + remedy;
  if (!detail.empty()) all += "\n" + detail;
  return all;
}

Error::Error(ExitCode code, std::vector<Problem> problems)
    : std::runtime_error(join_texts(problems)), code_(code), problems_(std::move(problems)) {}

Error Error::usage(std::string what, std::string remedy) {
  return {ExitCode::usage, {{{}, std::move(what), std::move(remedy)}}};
}
Error Error::refused(Place place, std::string what, std::string remedy) {
  return {ExitCode::refused, {{std::move(place), std::move(what), std::move(remedy)}}};
}
Error Error::refused(std::vector<Problem> problems) {
  return {ExitCode::refused, std::move(problems)};
}
Error Error::participant(std::string what, std::string remedy, std::string detail) {
  return {ExitCode::participant, {{{}, std::move(what), std::move(remedy), std::move(detail)}}};
}
Error Error::unstable(std::string what, std::string remedy, std::string detail) {
  return {ExitCode::unstable, {{{}, std::move(what), std::move(remedy), std::move(detail)}}};
}
Error Error::mismatch(std::string what, std::string remedy) {
  return {ExitCode::mismatch, {{{}, std::move(what), std::move(remedy)}}};
}
Error Error::environment(std::string what, std::string remedy) {
  return {ExitCode::environment, {{{}, std::move(what), std::move(remedy)}}};
}
Error Error::interrupted(std::string what) {
  return {ExitCode::interrupted, {{{}, std::move(what), {}}}};
}

std::string nearest(const std::string& name, const std::vector<std::string>& candidates) {
  // Names of 10 kB are legal input: the quadratic distance is only worth it for plausible typing
  // errors.
  constexpr size_t longest = 100;
  if (name.size() > longest) return {};
  std::string best;
  size_t best_distance = std::max<size_t>(2, name.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    if (candidate.size() > longest) continue;
    const size_t distance = edit_distance(name, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

std::string suggestion(const std::string& name, const std::vector<std::string>& candidates) {
  const std::string near = nearest(name, candidates);
  if (!near.empty()) return fmt::format("did you mean '{}'?", near);
  if (candidates.empty()) return "nothing is valid here";
  return fmt::format("valid: {}", fmt::join(candidates, ", "));
}

}  // namespace sandglass
