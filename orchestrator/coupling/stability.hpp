#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "coupling/memory.hpp"

namespace sandglass::coupling {

/// When the watch speaks.
struct StabilityLimits {
  bool active = true;
  /// Growth per window above which a field that oscillates diverges. Between 0.95 and 1.05 the
  /// verdict is open: this stands between them with room for oscillations that are sampled
  /// unevenly.
  double growth = 1.02;
  double monotone_growth = 1.04;  ///< the same without a change of sign, as some physics grows too
};

/// Which fields hold the energy of a system that nothing outside feeds.
struct EnergyLimits {
  std::vector<std::string> fields;  ///< none: not watched
  double growth = 2;                ///< over the first value, above which the run ends
};

/// Watches such an energy, which begins at 0 or above: what it gains is made by the coupling. An
/// exchange with a lag makes it slowly, by far less in a window than StabilityWatch looks for, as
/// long as a contact lasts; and a contact that opens holds every field within bounds.
class EnergyWatch {
 public:
  explicit EnergyWatch(double growth) : most_(growth) {}
  /// Takes the energy of the next window. A number is its growth over the first one above 0, and
  /// beyond the limit.
  std::optional<double> observe(double energy);
  /// Keeps or recalls what has been seen so far.
  void remember(Memory& memory, const std::string& name) { memory(name + ".first", first_); }

 private:
  double most_;
  double first_ = 0;
};

/// What the watch found in a field.
struct Finding {
  double growth = 0;         ///< of the change from window to window, per window
  bool alternating = false;  ///< the change turns its sign again and again
  std::string text() const;  ///< "grows 1.31 times per window, with alternating sign"
};

/// Watches one field, window by window, for a coupling that diverges or oscillates.
///
/// What is looked at is the change d(n) = x(n) - x(n-1): for a linear coupling it goes as G^n,
/// whatever the field converges to. Its largest size in every six windows is compared with that of
/// the six before. An oscillation that has grown in five such comparisons in a row, or a
/// thousandfold in fewer, beyond everything before, diverges (one that beats, almost alternating,
/// may take longer); so does one that grows twentyfold twice running. Of an oscillation that is
/// slower than these windows the largest changes between turns are compared: four times in a row
/// they must have grown, exponentially, or a thousandfold in fewer. A growth without oscillation
/// must be exponential over 24 windows (powers of the time, as of a free fall, are not).
/// Changes that are lost in rounding, below 1e-10 of the field, are not looked at.
class StabilityWatch {
 public:
  explicit StabilityWatch(StabilityLimits limits) : limits_(limits) {}

  /// Takes the values of the next window, rows of so many each. A finding means that the field
  /// diverges.
  std::optional<Finding> observe(std::span<const double> values, std::size_t row = 1);
  /// An oscillation that has decayed, or is decaying: worth a warning when the run has ended.
  [[nodiscard]] std::optional<Finding> oscillation() const;
  /// Keeps or recalls what has been seen so far.
  void remember(Memory& memory, const std::string& name);

 private:
  struct Block {
    double largest = 0;  ///< change
    int turns = 0;       ///< of its sign
    int windows = 0;
  };
  /// From one turn of the sign to the next.
  struct Swing {
    double largest = 0;  ///< change
    int windows = 0;
  };
  /// A change that turned its sign and grew twentyfold, twice in a row: nobody needs to wait.
  std::optional<Finding> exploding(double size, bool turned);
  void close_block();
  /// Takes the next change, as long as `turned` says its sign is not that of the one before.
  std::optional<Finding> slow_growth(double size, bool turned);
  [[nodiscard]] std::optional<Finding> verdict_on_swings() const;
  [[nodiscard]] std::optional<Finding> verdict() const;
  [[nodiscard]] std::optional<Finding> oscillating_growth() const;
  [[nodiscard]] std::optional<Finding> exponential_growth() const;

  StabilityLimits limits_;
  std::vector<double> last_;
  std::vector<double> last_change_;
  std::vector<double> now_;  ///< these two only so that no memory is taken in every window
  std::vector<double> change_;
  double scale_ = 0;
  Block block_;
  std::vector<Block> blocks_;  ///< the newest last
  Swing swing_;
  std::vector<Swing> swings_;  ///< the newest last
  double largest_swing_ = 0;   ///< change, before these swings
  double last_size_ = 0;       ///< of the change
  double last_growth_ = 0;     ///< of its size, where it turned its sign
  double largest_ever_ = 0;
  double largest_before_ = 0;  ///< change, before these blocks
  int oscillating_blocks_ = 0;
  double decay_ = 0;
};

}  // namespace sandglass::coupling
