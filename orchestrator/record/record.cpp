#include "record/record.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <utility>

#include "base/error.hpp"
#include "base/file.hpp"

namespace sandglass::record {
namespace {

void describe(hdf5::File& file) {
  file.set_attribute("/", "filetype", "sandglass record");
  file.set_attribute("/", "version", std::vector<std::int64_t>{1, 0});
}

void describe_field(hdf5::File& file, const RecordedField& field) {
  const std::string name = "/fields/" + field.name;
  file.set_attribute(name, "unit", field.unit);
  file.set_attribute(name, "from", field.from);
  file.set_attribute(name, "to", field.to);
}

class Descriptor {
 public:
  Descriptor(const std::string& path, int flags)
      : number_(::open(path.c_str(), flags | O_CLOEXEC)) {
    if (number_ < 0) throw_system_error("open the record", path, errno);
  }
  ~Descriptor() { ::close(number_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

void copy_bytes(const Descriptor& from, std::uint64_t from_offset, const Descriptor& to,
                std::uint64_t to_offset, std::uint64_t count) {
  std::vector<char> block(std::min<std::uint64_t>(count, 1U << 20U));
  while (count > 0) {
    const ssize_t read =
        ::pread(from.number(), block.data(), std::min<std::uint64_t>(count, block.size()),
                static_cast<off_t>(from_offset));
    if (read < 0 && errno == EINTR) continue;
    if (read <= 0) throw_system_error("read the record", "record.h5", read < 0 ? errno : EIO);
    for (ssize_t done = 0; done < read;) {
      const ssize_t written =
          ::pwrite(to.number(), block.data() + done, static_cast<std::size_t>(read - done),
                   static_cast<off_t>(to_offset) + done);
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) throw_system_error("write the record", "record.h5", errno);
      done += written;
    }
    from_offset += static_cast<std::uint64_t>(read);
    to_offset += static_cast<std::uint64_t>(read);
    count -= static_cast<std::uint64_t>(read);
  }
}

hdf5::Shape with_windows(std::int64_t windows, const hdf5::Shape& shape) {
  hdf5::Shape all{windows};
  all.insert(all.end(), shape.begin(), shape.end());
  return all;
}

}  // namespace

Record::Record(std::string path, std::int64_t windows, std::vector<RecordedField> fields,
               std::vector<std::string> timing_columns, std::int64_t kept)
    : path_(std::move(path)),
      planned_(windows),
      fields_(std::move(fields)),
      timing_columns_(std::move(timing_columns)) {
  // Made under another name: whoever looks finds no record or a whole one.
  const std::string temporary = path_ + ".part";
  hdf5::File file(temporary, hdf5::File::Mode::create);
  describe(file);
  const auto reserve = [&](const std::string& name, hdf5::Type type, const hdf5::Shape& shape) {
    const hdf5::Location at = file.reserve(name, type, with_windows(windows, shape));
    return Column{at.offset, static_cast<std::uint64_t>(hdf5::count_of(shape)) * 8};
  };
  windows_ = Column{file.reserve("/windows", hdf5::Type::int64, {1}).offset, 8};
  time_ = reserve("/time", hdf5::Type::float64, {2});
  iterations_ = reserve("/iterations", hdf5::Type::int64, {});
  for (const std::string& column : timing_columns_) {
    timings_.push_back(reserve("/timings/" + column, hdf5::Type::float64, {}));
  }
  for (const RecordedField& field : fields_) {
    counts_.push_back(field.variable ? reserve("/counts/" + field.name, hdf5::Type::int64, {})
                                     : Column{});
    values_.push_back(reserve("/fields/" + field.name, hdf5::Type::float64, field.shape));
    describe_field(file, field);
  }
  file.close();
  if (kept > 0) take_over(temporary, kept);
  if (std::rename(temporary.c_str(), path_.c_str()) != 0) {
    throw_system_error("rename", temporary, errno);
  }
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor_ < 0) throw_system_error("open the record", path_, errno);
}

void Record::take_over(const std::string& to, std::int64_t kept) {
  const hdf5::File old(path_, hdf5::File::Mode::read);
  if (const std::int64_t held = windows_of(path_); held < kept) {
    throw Error::environment(
        fmt::format("the record '{}' holds {} windows, fewer than the checkpoint's {}", path_, held,
                    kept),
        "it was changed after the run: run anew");
  }
  const Descriptor from(path_, O_RDONLY);
  const Descriptor target(to, O_WRONLY);
  const auto copy = [&](const std::string& name, const Column& column) {
    copy_bytes(from, old.location(name).offset, target, column.offset,
               static_cast<std::uint64_t>(kept) * column.row_bytes);
  };
  copy("/time", time_);
  copy("/iterations", iterations_);
  for (std::size_t t = 0; t < timings_.size(); ++t) {
    copy("/timings/" + timing_columns_[t], timings_[t]);
  }
  for (std::size_t f = 0; f < fields_.size(); ++f) {
    if (fields_[f].variable) copy("/counts/" + fields_[f].name, counts_[f]);
    copy("/fields/" + fields_[f].name, values_[f]);
  }
  appended_ = kept;
  const auto at = static_cast<off_t>(windows_.offset);
  if (::pwrite(target.number(), &appended_, sizeof appended_, at) != sizeof appended_ ||
      ::fsync(target.number()) != 0) {
    throw_system_error("write the record", to, errno);
  }
}

Record::~Record() {
  writer_.reset();
  if (descriptor_ >= 0) ::close(descriptor_);
}

void Record::append(const Row& row) {
  if (!writer_) {
    writer_ = std::make_unique<RowWriter>(descriptor_, path_, windows_.offset, appended_);
  }
  const auto index = static_cast<std::uint64_t>(appended_);
  pieces_.clear();
  const auto put = [&](const Column& column, const void* bytes, std::size_t count) {
    pieces_.push_back({column.offset + index * column.row_bytes, bytes, count});
  };
  const double time[2] = {row.begin, row.end};
  put(time_, time, sizeof time);
  put(iterations_, &row.iterations, sizeof row.iterations);
  for (std::size_t f = 0; f < fields_.size(); ++f) {
    put(values_[f], row.fields[f].values.data(), row.fields[f].values.size_bytes());
    if (fields_[f].variable) put(counts_[f], &row.fields[f].count, sizeof row.fields[f].count);
  }
  for (std::size_t t = 0; t < timings_.size(); ++t)
    put(timings_[t], &row.timings[t], sizeof(double));
  tell([&] { writer_->append(pieces_, appended_ + 1); });
  ++appended_;
}

void Record::flush() {
  if (writer_) tell([&] { writer_->flush(); });
  if (::fsync(descriptor_) != 0) throw_system_error("flush the record", path_, errno);
}

template <typename Write>
void Record::tell(Write write) {
  try {
    write();
  } catch (const Error&) {
    told_ = true;
    throw;
  }
}

std::int64_t Record::windows() const { return writer_ ? writer_->complete() : appended_; }

void Record::close() {
  if (descriptor_ < 0) return;
  std::exception_ptr failure;
  try {
    if (writer_) writer_->flush();
  } catch (const Error&) {
    // Whoever has heard of it already is not told again.
    if (!told_) failure = std::current_exception();
    appended_ = windows();
  }
  writer_.reset();
  const int descriptor = std::exchange(descriptor_, -1);
  const bool flushed = ::fsync(descriptor) == 0;
  const int number = errno;
  if (::close(descriptor) != 0 || !flushed) throw_system_error("flush the record", path_, number);
  if (appended_ != planned_) cut_if_possible();
  if (failure) std::rethrow_exception(failure);
}

void Record::cut_if_possible() {
  try {
    const std::string shorter = path_ + ".part";
    copy_windows(path_, shorter, appended_);
    if (std::rename(shorter.c_str(), path_.c_str()) != 0) {
      throw_system_error("rename", shorter, errno);
    }
  } catch (const std::exception&) {
    // A full disk most likely, and why the run ended. The long file is as whole: /windows counts.
    std::error_code ignored;
    std::filesystem::remove(path_ + ".part", ignored);
  }
}

std::int64_t windows_of(const std::string& path) {
  if (!std::filesystem::exists(path)) return 0;
  return hdf5::File(path, hdf5::File::Mode::read).read_counts("/windows").at(0);
}

void copy_windows(const std::string& from_path, const std::string& to_path, std::int64_t windows) {
  struct Piece {
    std::uint64_t from;
    hdf5::Location to;
  };
  std::vector<Piece> pieces;
  const hdf5::File from(from_path, hdf5::File::Mode::read);
  hdf5::File to(to_path, hdf5::File::Mode::create);
  describe(to);
  to.write("/windows", {1}, std::vector<std::int64_t>{windows});
  const auto reserve = [&](const std::string& name, hdf5::Type type) {
    hdf5::Shape shape = from.shape(name);
    shape[0] = windows;
    pieces.push_back({from.location(name).offset, to.reserve(name, type, shape)});
  };
  const auto each = [&](const std::string& group, hdf5::Type type) {
    if (!from.exists(group)) return;
    for (const std::string& name : from.list(group)) {
      reserve(fmt::format("{}/{}", group, name), type);
    }
  };
  reserve("/time", hdf5::Type::float64);
  reserve("/iterations", hdf5::Type::int64);
  each("/timings", hdf5::Type::float64);
  each("/counts", hdf5::Type::int64);
  each("/fields", hdf5::Type::float64);
  for (const std::string& field :
       from.exists("/fields") ? from.list("/fields") : std::vector<std::string>{}) {
    for (const char* attribute : {"unit", "from", "to"}) {
      const std::string name = "/fields/" + field;
      to.set_attribute(name, attribute, from.text_attribute(name, attribute));
    }
  }
  to.close();
  // In blocks: a field of all windows may be larger than the memory.
  const Descriptor source(from_path, O_RDONLY);
  const Descriptor target(to_path, O_WRONLY);
  for (const Piece& piece : pieces) {
    copy_bytes(source, piece.from, target, piece.to.offset, piece.to.bytes);
  }
}

}  // namespace sandglass::record
