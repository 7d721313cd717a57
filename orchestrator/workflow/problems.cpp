#include "workflow/problems.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

namespace sandglass::workflow {
namespace {

constexpr std::size_t most_kept = 500;
constexpr std::size_t most_shown = 50;

auto order_of(const Problem& problem) {
  return std::tie(problem.place.file, problem.place.line, problem.place.column, problem.what);
}

}  // namespace

bool Problems::full() {
  if (problems_.size() < most_kept) return false;
  ++dropped_;
  return true;
}

void Problems::add(Place place, std::string what, std::string remedy) {
  if (!full()) problems_.push_back({std::move(place), std::move(what), std::move(remedy)});
}

void Problems::add(const std::vector<Problem>& problems) {
  for (const Problem& problem : problems) add(problem.place, problem.what, problem.remedy);
}

void Problems::unknown(Place place, const std::string& what, const std::string& name,
                       const std::vector<std::string>& candidates) {
  if (full()) return;
  problems_.push_back(
      {std::move(place), fmt::format("{} {}", what, in_quotes(name)), suggest(name, candidates)});
}

void Problems::raise_if_any() const {
  if (problems_.empty()) return;
  // The cases of a choice share their base, so the same problem may have been met more than once.
  std::vector<Problem> sorted = problems_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Problem& a, const Problem& b) { return order_of(a) < order_of(b); });
  sorted.erase(
      std::unique(sorted.begin(), sorted.end(),
                  [](const Problem& a, const Problem& b) { return order_of(a) == order_of(b); }),
      sorted.end());
  if (sorted.size() + dropped_ > most_shown) {
    const std::size_t more = sorted.size() + dropped_ - std::min(sorted.size(), most_shown);
    sorted.resize(std::min(sorted.size(), most_shown));
    Problem rest;
    rest.what = fmt::format("and {} more problems", more);
    sorted.push_back(std::move(rest));
  }
  throw Error::refused(std::move(sorted));
}

std::string in_quotes(const std::string& text) {
  constexpr std::size_t longest = 60;
  if (text.size() <= longest) return fmt::format("'{}'", text);
  std::size_t end = longest;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return fmt::format("'{}...'", text.substr(0, end));
}

std::string suggest(const std::string& name, const std::vector<std::string>& candidates) {
  constexpr std::size_t most = 20;
  if (candidates.size() <= most) return suggestion(name, candidates);
  if (const std::string near = nearest(name, candidates); !near.empty()) {
    return fmt::format("did you mean '{}'?", near);
  }
  const std::vector<std::string> first(candidates.begin(), candidates.begin() + most);
  return fmt::format("valid: {} and {} more", fmt::join(first, ", "), candidates.size() - most);
}

}  // namespace sandglass::workflow
