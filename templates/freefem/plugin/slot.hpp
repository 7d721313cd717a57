#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace sandglass {

/// A participant's side of its slot (templates/README.md, "The slot"): an HDF5 file whose datasets
/// never move, mapped into memory once. HDF5 is asked where the bytes are and then closed; from
/// then on an exchange is a copy.
class Slot {
 public:
  /// Where a field lives.
  struct Field {
    std::vector<std::int64_t> capacity;  ///< the largest shape; only the first axis may be smaller
    std::string unit;
    double* values = nullptr;       ///< null where the slot is not mapped
    std::int64_t* shape = nullptr;  ///< as many as capacity
  };

  /// Opens and, for transport "mapped", maps the slot. Throws std::runtime_error when the file is
  /// missing, is no slot of version 1, or holds a dataset that could move.
  explicit Slot(const std::string& path);
  ~Slot();
  Slot(const Slot&) = delete;
  Slot& operator=(const Slot&) = delete;

  [[nodiscard]] bool mapped() const { return base_ != nullptr; }
  /// Throws std::runtime_error that lists the fields there are.
  [[nodiscard]] const Field& in(const std::string& field) const;
  [[nodiscard]] const Field& out(const std::string& field) const;
  [[nodiscard]] const std::map<std::string, Field>& all_out() const { return out_; }

  [[nodiscard]] const std::int64_t* window() const { return window_; }  ///< index, iteration
  [[nodiscard]] const double* time() const { return time_; }            ///< begin, end in s
  [[nodiscard]] double* seconds() const { return seconds_; }

 private:
  void map(const std::string& path);

  std::map<std::string, Field> in_, out_;
  std::int64_t* window_ = nullptr;
  double* time_ = nullptr;
  double* seconds_ = nullptr;
  char* base_ = nullptr;
  std::size_t size_ = 0;
};

/// The shape that an array of `length` values takes in a field of this capacity: whole rows when it
/// can be cut into rows, otherwise a shape that nobody can mistake for a right one.
std::vector<std::int64_t> shape_sent(const std::vector<std::int64_t>& capacity,
                                     std::int64_t length);

}  // namespace sandglass
