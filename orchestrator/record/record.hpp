#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hdf5/hdf5.hpp"

namespace sandglass::record {

struct RecordedField {
  std::string name;
  std::string unit;
  std::string from;
  std::string to;  ///< empty: recorded only
  hdf5::Shape shape;
  bool variable = false;  ///< the first axis is an upper limit; the actual count is recorded too
};

/// What one window adds. `fields` in the order of the layout.
struct Row {
  double begin = 0;
  double end = 0;
  std::int64_t iterations = 1;
  struct Values {
    std::span<const double> values;
    std::int64_t count = 0;  ///< rows of the first axis, for variable fields
  };
  std::vector<Values> fields;
  std::vector<double> timings;  ///< s, in the order of the columns
};

/// The history of a run, record.h5 (format 1.0, described in README.md of this folder).
///
/// The number of windows is known beforehand, so that every dataset is contiguous and has its place
/// in the file from the start; a window is appended by writing its bytes there. The file is whole
/// and readable by h5py at every moment, and a process that is killed loses no window that was
/// appended: no HDF5 structure changes after the start. Space is taken as windows come.
class Record {
 public:
  /// With `kept` above zero it goes on behind that many windows of the record that is there, which
  /// must have them and the same layout.
  Record(std::string path, std::int64_t windows, std::vector<RecordedField> fields,
         std::vector<std::string> timing_columns, std::int64_t kept = 0);
  ~Record();
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;

  /// Throws Error::environment (a full disk among others); windows appended before stay whole.
  void append(const Row& row);
  [[nodiscard]] std::int64_t windows() const { return appended_; }
  /// Brings what was appended to the disk.
  void flush();
  /// Flushes. A run that ended before its last planned window gets its datasets cut to
  /// what was done, where the disk has room for that.
  void close();

 private:
  struct Column {
    std::uint64_t offset = 0;     ///< of row 0 in the file
    std::uint64_t row_bytes = 0;  ///< of one row
  };
  /// Takes the first `kept` windows over from the record at `path_` into the new file.
  void take_over(const std::string& to, std::int64_t kept);
  void write_at(std::uint64_t offset, const void* bytes, std::size_t count);
  void cut();

  std::string path_;
  std::int64_t planned_ = 0;
  std::int64_t appended_ = 0;
  std::vector<RecordedField> fields_;
  std::vector<std::string> timing_columns_;
  Column time_;
  Column iterations_;
  Column windows_;
  std::vector<Column> values_;
  std::vector<Column> counts_;
  std::vector<Column> timings_;
  int descriptor_ = -1;
};

}  // namespace sandglass::record
