#include "record/row_writer.hpp"

#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "base/error.hpp"
#include "base/file.hpp"

namespace sandglass::record {
namespace {

/// How long rows gather, unless they are many: short for whoever watches the file, long against a
/// window and against a write.
constexpr std::chrono::milliseconds kGather{10};
constexpr std::size_t kManyBytes = 1U << 20U;
/// What may wait to be written before the caller does: more would not stay in the processor's
/// cache.
constexpr std::size_t kMostBytes = 8U << 20U;
constexpr int kMostParts = 256;  // of one call; the system takes 1024

}  // namespace

void RowWriter::Batch::clear() {
  // Their memory stays: taking it anew for every row would cost more than copying.
  bytes.clear();
  pieces.clear();
  rows.clear();
}

RowWriter::RowWriter(int descriptor, std::string path, std::uint64_t count_offset,
                     std::int64_t complete)
    : descriptor_(descriptor),
      path_(std::move(path)),
      count_offset_(count_offset),
      complete_(complete),
      thread_([this] { work(); }) {}

RowWriter::~RowWriter() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void RowWriter::append(const std::vector<Piece>& row, std::int64_t complete) {
  bool wake = false;
  {
    std::unique_lock lock(mutex_);
    done_.wait(lock, [&] { return waiting_.bytes.size() < kMostBytes || failure_; });
    rethrow_failure();
    for (const Piece& piece : row) {
      const auto* from = static_cast<const std::byte*>(piece.bytes);
      waiting_.pieces.push_back({piece.offset, waiting_.bytes.size(), piece.size});
      waiting_.bytes.insert(waiting_.bytes.end(), from, from + piece.size);
    }
    waiting_.rows.push_back({waiting_.pieces.size(), complete});
    wake = std::exchange(idle_, false) || waiting_.bytes.size() >= kManyBytes;
  }
  if (wake) wake_.notify_one();
}

void RowWriter::flush() {
  std::unique_lock lock(mutex_);
  hurried_ = true;
  wake_.notify_one();
  done_.wait(lock, [&] { return (waiting_.rows.empty() && !busy_) || failure_; });
  hurried_ = false;
  rethrow_failure();
}

std::int64_t RowWriter::complete() const {
  const std::lock_guard lock(mutex_);
  return complete_;
}

void RowWriter::rethrow_failure() const {
  if (failure_) std::rethrow_exception(failure_);
}

void RowWriter::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    idle_ = waiting_.rows.empty();
    wake_.wait(lock, [&] { return !waiting_.rows.empty() || ending_; });
    if (waiting_.rows.empty()) return;
    idle_ = false;
    std::swap(waiting_, writing_);
    busy_ = true;
    done_.notify_all();
    lock.unlock();
    write(writing_);
    writing_.clear();
    lock.lock();
    busy_ = false;
    done_.notify_all();
    if (failure_) return;
    // Not woken by rows: so the caller is spared a call into the system for each.
    wake_.wait_for(lock, kGather,
                   [&] { return hurried_ || ending_ || waiting_.bytes.size() >= kManyBytes; });
  }
}

void RowWriter::write(Batch& batch) {
  try {
    write_together(batch);
    write_count(batch.rows.back().complete);
  } catch (const Error&) {
    // Some of the rows may have their place on the disk all the same.
    try {
      write_one_by_one(batch);
    } catch (const Error&) {
      const std::lock_guard lock(mutex_);
      failure_ = std::current_exception();
    }
  }
}

void RowWriter::write_together(const Batch& batch) const {
  std::vector<StoredPiece> sorted = batch.pieces;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const StoredPiece& a, const StoredPiece& b) { return a.offset < b.offset; });
  const StoredPiece* end = sorted.data() + sorted.size();
  for (const StoredPiece* first = sorted.data(); first != end;) {
    const StoredPiece* last = first + 1;
    while (last != end && last - first < kMostParts &&
           last->offset == (last - 1)->offset + (last - 1)->size) {
      ++last;
    }
    write_all(batch, first, last);
    first = last;
  }
}

void RowWriter::write_one_by_one(const Batch& batch) {
  std::size_t begin = 0;
  for (const Row& row : batch.rows) {
    for (; begin < row.end; ++begin) {
      write_all(batch, &batch.pieces[begin], &batch.pieces[begin] + 1);
    }
    write_count(row.complete);
  }
}

/// Pieces that lie behind one another in the file.
void RowWriter::write_all(const Batch& batch, const StoredPiece* first,
                          const StoredPiece* last) const {
  std::array<iovec, kMostParts> parts{};
  int count = 0;
  for (const StoredPiece* piece = first; piece != last; ++piece) {
    if (piece->size == 0) continue;
    // The system's type has no const, but it only reads.
    parts[static_cast<std::size_t>(count++)] = {
        const_cast<std::byte*>(batch.bytes.data() + piece->begin), piece->size};
  }
  std::uint64_t offset = first->offset;
  for (iovec* next = parts.data(); count > 0;) {
    const ssize_t got = ::pwritev(descriptor_, next, count, static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw_system_error("append to the record", path_, errno);
    auto written = static_cast<std::size_t>(got);
    offset += written;
    for (; count > 0 && written >= next->iov_len; --count, ++next) written -= next->iov_len;
    if (count > 0) {
      next->iov_base = static_cast<std::byte*>(next->iov_base) + written;
      next->iov_len -= written;
    }
  }
}

void RowWriter::write_count(std::int64_t complete) {
  ssize_t got = 0;
  do {
    got = ::pwrite(descriptor_, &complete, sizeof complete, static_cast<off_t>(count_offset_));
  } while (got < 0 && errno == EINTR);
  if (got < 0) throw_system_error("append to the record", path_, errno);
  const std::lock_guard lock(mutex_);
  complete_ = complete;
}

}  // namespace sandglass::record
