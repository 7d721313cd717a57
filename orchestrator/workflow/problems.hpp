#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/error.hpp"

namespace sandglass::workflow {

/// Everything found wrong in one pass over a workflow. A hostile file may be wrong in a hundred
/// thousand places: beyond a limit problems are only counted.
class Problems {
 public:
  void add(Place place, std::string what, std::string remedy = {});
  void add(const std::vector<Problem>& problems);
  /// `what` 'name', with the nearest of the candidates, or the valid ones.
  void unknown(Place place, const std::string& what, const std::string& name,
               const std::vector<std::string>& candidates);
  [[nodiscard]] bool empty() const { return problems_.empty(); }
  /// Throws Error::refused with the problems in the order of their places, each once, when there
  /// are any; at most 50, and how many more there are.
  void raise_if_any() const;

 private:
  [[nodiscard]] bool full();

  std::vector<Problem> problems_;
  std::size_t dropped_ = 0;
};

/// The text in quotes for a message: shortened when long.
std::string in_quotes(const std::string& text);

/// As sandglass::suggestion, but names no more than twenty candidates.
std::string suggest(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace sandglass::workflow
