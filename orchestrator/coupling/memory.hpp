#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include "base/error.hpp"

namespace sandglass::coupling {

/// What the coupling itself carries from one window to the next, as arrays by name: a checkpoint
/// holds it beside the participants' own states.
///
/// Keeping and recalling is one and the same walk over the members (`remember` of each class), so
/// that what is kept and what is recalled cannot differ.
class Memory {
 public:
  using Arrays = std::map<std::string, std::vector<double>>;

  /// Empty: members are written into it.
  Memory() = default;
  /// Recalls: members are set from these arrays.
  explicit Memory(Arrays arrays) : arrays_(std::move(arrays)), recalling_(true) {}

  [[nodiscard]] const Arrays& arrays() const { return arrays_; }

  /// Throws Error::environment where an array to be recalled is missing.
  void operator()(const std::string& name, std::vector<double>& values) {
    if (!recalling_) {
      arrays_[name] = values;
      return;
    }
    const auto found = arrays_.find(name);
    if (found == arrays_.end()) {
      throw Error::environment("the checkpoint does not hold '" + name + "'",
                               "it was written by another version, or is damaged: go on from an "
                               "earlier one, or run anew");
    }
    values = found->second;
  }

  /// Whole numbers below 2^53 are exact as doubles.
  void operator()(const std::string& name, std::vector<std::int64_t>& values) {
    std::vector<double> numbers(values.begin(), values.end());
    (*this)(name, numbers);
    values.clear();
    for (const double number : numbers) values.push_back(static_cast<std::int64_t>(number));
  }

  template <typename Number, typename = std::enable_if_t<std::is_arithmetic_v<Number>>>
  void operator()(const std::string& name, Number& value) {
    std::vector<double> numbers{static_cast<double>(value)};
    (*this)(name, numbers);
    if (numbers.size() == 1) value = static_cast<Number>(numbers[0]);
  }

 private:
  Arrays arrays_;
  bool recalling_ = false;
};

}  // namespace sandglass::coupling
