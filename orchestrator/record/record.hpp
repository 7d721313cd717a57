#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hdf5/hdf5.hpp"
#include "record/row_writer.hpp"

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
/// in the file from the start; a window is appended by writing its bytes there, behind the back of
/// the caller (RowWriter). The file is whole and readable by h5py at every moment, because no HDF5
/// structure changes after the start; a process that is killed loses at most the windows of its
/// last milliseconds. Space is taken as windows come.
class Record {
 public:
  /// With `kept` above zero it goes on behind that many windows of the record that is there, which
  /// must have them and the same layout.
  Record(std::string path, std::int64_t windows, std::vector<RecordedField> fields,
         std::vector<std::string> timing_columns, std::int64_t kept = 0);
  ~Record();
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;

  /// Hands over one more window, which is then on its way into the file. Throws Error::environment
  /// when this or an earlier one cannot be written (a full disk among others); windows before that
  /// one are whole.
  void append(const Row& row);
  /// Returns when every window appended is on the disk. Throws as append does.
  void flush();
  /// Complete windows in the file.
  [[nodiscard]] std::int64_t windows() const;
  /// Flushes; throws as append does, if that has not. A
  /// run that ended before its last planned window gets its datasets cut to
  /// what was done, where the disk has room for that.
  void close();

 private:
  struct Column {
    std::uint64_t offset = 0;     ///< of row 0 in the file
    std::uint64_t row_bytes = 0;  ///< of one row
  };
  /// Takes the first `kept` windows over from the record at `path_` into the new file.
  void take_over(const std::string& to, std::int64_t kept);
  template <typename Write>
  void tell(Write write);
  void cut_if_possible();

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
  std::unique_ptr<RowWriter> writer_;
  std::vector<RowWriter::Piece> pieces_;  ///< of the row being appended
  bool told_ = false;                     ///< the caller has had the failure
};

/// How many windows the record at `path` holds; 0 where there is none.
std::int64_t windows_of(const std::string& path);

/// Writes the first `windows` windows of the record at `from`, which may be growing meanwhile, as a
/// record of its own to `to`. There must be as many.
void copy_windows(const std::string& from, const std::string& to, std::int64_t windows);

}  // namespace sandglass::record
