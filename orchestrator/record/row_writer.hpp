#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace sandglass::record {

/// Writes the rows of a record on a thread of its own, so that no window waits for the disk.
///
/// A row handed over is on its way at once; rows that come faster than about one in ten
/// milliseconds are written together. The number of complete rows is written behind what it counts,
/// so that the file is whole at every moment. A disk that cannot keep up holds the caller back at
/// last.
class RowWriter {
 public:
  /// Bytes and their place in the file.
  struct Piece {
    std::uint64_t offset = 0;
    const void* bytes = nullptr;
    std::size_t size = 0;
  };

  /// `descriptor` stays the caller's; `path` is for messages. The number of complete rows, an
  /// int64, is written at `count_offset`; `complete` of them are there already.
  RowWriter(int descriptor, std::string path, std::uint64_t count_offset, std::int64_t complete);
  /// Writes what was handed over. Whoever must know of a failure calls flush() before.
  ~RowWriter();
  RowWriter(const RowWriter&) = delete;
  RowWriter& operator=(const RowWriter&) = delete;

  /// Copies one row; with it, `complete` rows are in the file. Throws the Error::environment that
  /// an earlier row ended in.
  void append(const std::vector<Piece>& row, std::int64_t complete);
  /// Returns when all rows are in the file (not necessarily on the disk: fsync). Throws as append.
  void flush();
  /// Complete rows in the file.
  [[nodiscard]] std::int64_t complete() const;

 private:
  struct StoredPiece {
    std::uint64_t offset = 0;
    std::size_t begin = 0;  ///< in the bytes of the batch
    std::size_t size = 0;
  };
  struct Row {
    std::size_t end = 0;  ///< one behind its last piece
    std::int64_t complete = 0;
  };
  struct Batch {
    std::vector<std::byte> bytes;
    std::vector<StoredPiece> pieces;
    std::vector<Row> rows;
    void clear();
  };

  void work();
  void write(Batch& batch);
  void write_together(const Batch& batch) const;
  void write_one_by_one(const Batch& batch);
  void write_all(const Batch& batch, const StoredPiece* first, const StoredPiece* last) const;
  void write_count(std::int64_t complete);
  void rethrow_failure() const;

  const int descriptor_;
  const std::string path_;
  const std::uint64_t count_offset_;

  mutable std::mutex mutex_;
  std::condition_variable wake_;  ///< the thread: there is work, or an end
  std::condition_variable done_;  ///< the caller: a batch was taken, or is written
  Batch waiting_;
  Batch writing_;         ///< the thread's own
  bool idle_ = true;      ///< the thread sleeps until it is woken
  bool busy_ = false;     ///< a batch is being written
  bool hurried_ = false;  ///< somebody waits in flush()
  bool ending_ = false;
  std::int64_t complete_;
  std::exception_ptr failure_;
  std::thread thread_;  ///< last: it uses all the others
};

}  // namespace sandglass::record
