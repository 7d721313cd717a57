#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "exchange/field.hpp"

namespace sandglass::exchange {

/// The coupling window that a participant is asked to compute.
struct Window {
  std::int64_t index = 1;      ///< from 1
  std::int64_t iteration = 1;  ///< from 1, within the window
  double begin = 0;            ///< s
  double end = 0;              ///< s
};

/// The orchestrator's end of a participant's slot: an HDF5 file with contiguous, early-allocated
/// datasets, mapped into memory once (templates/README.md describes the format).
class Slot {
 public:
  /// Creates the file (replacing an old one), gives it its disk space now, and maps it. `inputs`
  /// go to the participant, `outputs` come from it. Throws Error::environment, for a full disk too.
  Slot(std::string path, const std::string& participant, const std::vector<FieldLayout>& inputs,
       const std::vector<FieldLayout>& outputs, bool mapped);
  ~Slot();
  Slot(const Slot&) = delete;
  Slot& operator=(const Slot&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  void set_window(const Window& window);
  /// The one set last: what is in the slot may have been overwritten.
  [[nodiscard]] const Window& window() const { return window_; }
  /// Throws Error::participant when the file was made shorter: to touch what is gone would be a
  /// deadly signal. To be asked whenever the participant has been at work.
  void require_whole() const;

  /// Gives input number `input` the values of this shape; at most its capacity.
  void give(std::size_t input, std::span<const double> values, const Shape& shape);
  /// What output number `output` holds now, with the shape the participant says it has (a first
  /// axis below zero: it was not sent). The values are cut to the capacity: compare the shape
  /// before use.
  struct Taken {
    std::span<const double> values;
    Shape shape;
  };
  [[nodiscard]] Taken take(std::size_t output) const;
  /// Forgets the outputs, so that one which is not sent again is seen as missing.
  void clear_outputs();
  /// Seconds that the participant says its last command took.
  [[nodiscard]] double seconds() const;

  /// The fallback where no memory can be shared: the inputs as a fresh file, written under another
  /// name and renamed; the outputs of a file that the participant has made the same way.
  void write_fresh(const std::string& path) const;
  void read_fresh(const std::string& path);

 private:
  struct Place;
  struct Map;
  std::string path_;
  std::string participant_;
  Window window_{0, 0, 0, 0};
  std::vector<FieldLayout> inputs_;
  std::vector<FieldLayout> outputs_;
  /// Shapes of outputs that came in a fresh file with another number of axes than they should have.
  std::vector<std::optional<Shape>> other_ranks_;
  std::unique_ptr<Map> map_;
};

}  // namespace sandglass::exchange
