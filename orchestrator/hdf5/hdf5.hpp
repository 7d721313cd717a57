#pragma once

#include <cstdint>
#include <string>
#include <vector>

/// The only room that sees HDF5's handles. Everything here throws Error::environment with HDF5's
/// own account of what went wrong; nothing prints.
namespace sandglass::hdf5 {

using Shape = std::vector<std::int64_t>;

/// Number of values in an array of this shape.
std::int64_t count_of(const Shape& shape);

enum class Type { float64, int64 };

/// Where a contiguous dataset's bytes are in its file. They never move.
struct Location {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
};

/// An open file. Closed in the destructor; call close() where a failure must be seen.
class File {
 public:
  enum class Mode { create, read, change };
  /// `create` replaces what is there. Locking is off: two processes share slots by protocol.
  File(std::string path, Mode mode);
  ~File();
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  /// A contiguous dataset whose space is allocated now, so that its bytes have a place in the file;
  /// not filled (the file is extended, not written; it reads as zeros). Groups on the way are made.
  /// A shape without values has no place: {0, 0}.
  Location reserve(const std::string& name, Type type, const Shape& shape);
  /// Of a contiguous dataset that is there; {0, 0} where it has no values.
  [[nodiscard]] Location location(const std::string& name) const;
  void write(const std::string& name, const Shape& shape, const std::vector<double>& values);
  void write(const std::string& name, const Shape& shape, const std::vector<std::int64_t>& values);

  [[nodiscard]] bool exists(const std::string& name) const;
  [[nodiscard]] Shape shape(const std::string& name) const;
  /// The whole dataset, or its first `rows` along the first axis.
  [[nodiscard]] std::vector<double> read_numbers(const std::string& name,
                                                 std::int64_t rows = kAllRows) const;
  [[nodiscard]] std::vector<std::int64_t> read_counts(const std::string& name,
                                                      std::int64_t rows = kAllRows) const;
  static constexpr std::int64_t kAllRows = -1;
  /// The names directly in a group, sorted.
  [[nodiscard]] std::vector<std::string> list(const std::string& group) const;

  /// Attributes of the object `name` ("/" is the root). An existing one is replaced.
  void set_attribute(const std::string& name, const std::string& attribute,
                     const std::string& text);
  void set_attribute(const std::string& name, const std::string& attribute,
                     const std::vector<std::int64_t>& numbers);
  [[nodiscard]] std::string text_attribute(const std::string& name,
                                           const std::string& attribute) const;
  [[nodiscard]] std::vector<std::int64_t> count_attribute(const std::string& name,
                                                          const std::string& attribute) const;

  void close();

 private:
  std::string path_;
  std::int64_t handle_ = -1;
};

/// "1.10.8"
std::string library_version();

}  // namespace sandglass::hdf5
