#include "exchange/slot.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <utility>

#include "base/error.hpp"
#include "base/file.hpp"
#include "hdf5/hdf5.hpp"

namespace sandglass::exchange {

std::string shape_text(const Shape& shape) { return fmt::format("[{}]", fmt::join(shape, ", ")); }

/// Where the parts of one field are in the mapped memory.
struct Slot::Place {
  double* values = nullptr;
  std::int64_t* shape = nullptr;
};

struct Slot::Map {
  std::byte* memory = nullptr;
  std::size_t bytes = 0;
  int descriptor = -1;
  std::int64_t* window = nullptr;
  double* time = nullptr;
  double* seconds = nullptr;
  std::vector<Place> inputs;
  std::vector<Place> outputs;

  ~Map() {
    if (memory != nullptr) ::munmap(memory, bytes);
    if (descriptor >= 0) ::close(descriptor);
  }
};

namespace {

struct FieldOffsets {
  hdf5::Location values;
  hdf5::Location shape;
};

FieldOffsets reserve_field(hdf5::File& file, const std::string& side, const FieldLayout& field) {
  const std::string group = "/" + side + "/" + field.name;
  const auto rank = static_cast<std::int64_t>(field.capacity.size());
  FieldOffsets offsets{file.reserve(group + "/values", hdf5::Type::float64, field.capacity),
                       file.reserve(group + "/shape", hdf5::Type::int64, {rank})};
  file.set_attribute(group + "/values", "unit", field.unit);
  return offsets;
}

void describe(hdf5::File& file, const std::string& participant, const std::string& transport) {
  file.set_attribute("/", "filetype", "sandglass slot");
  file.set_attribute("/", "version", std::vector<std::int64_t>{1, 0});
  file.set_attribute("/", "participant", participant);
  file.set_attribute("/", "transport", transport);
}

}  // namespace

Slot::Slot(std::string path, const std::string& participant, const std::vector<FieldLayout>& inputs,
           const std::vector<FieldLayout>& outputs, bool mapped)
    : path_(std::move(path)),
      participant_(participant),
      inputs_(inputs),
      outputs_(outputs),
      other_ranks_(outputs.size()),
      map_(std::make_unique<Map>()) {
  hdf5::File file(path_, hdf5::File::Mode::create);
  describe(file, participant, mapped ? "mapped" : "file");
  const hdf5::Location window = file.reserve("/window", hdf5::Type::int64, {2});
  const hdf5::Location time = file.reserve("/time", hdf5::Type::float64, {2});
  const hdf5::Location seconds = file.reserve("/seconds", hdf5::Type::float64, {1});
  std::vector<FieldOffsets> input_offsets;
  std::vector<FieldOffsets> output_offsets;
  for (const FieldLayout& field : inputs_)
    input_offsets.push_back(reserve_field(file, "in", field));
  for (const FieldLayout& field : outputs_) {
    output_offsets.push_back(reserve_field(file, "out", field));
  }
  file.close();

  const int descriptor = ::open(path_.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) throw_system_error("open the slot", path_, errno);
  map_->descriptor = descriptor;
  const off_t size = ::lseek(descriptor, 0, SEEK_END);
  // A hole in a mapped file on a full disk would be a deadly signal later; ask for the space now.
  const int full = ::posix_fallocate(descriptor, 0, size);
  if (full != 0) throw_system_error("allocate the slot", path_, full);
  void* memory =
      ::mmap(nullptr, static_cast<size_t>(size), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  if (memory == MAP_FAILED) throw_system_error("map the slot", path_, errno);
  map_->memory = static_cast<std::byte*>(memory);
  map_->bytes = static_cast<size_t>(size);

  const auto counts = [&](hdf5::Location at) {
    return reinterpret_cast<std::int64_t*>(map_->memory + at.offset);
  };
  const auto numbers = [&](hdf5::Location at) {
    return reinterpret_cast<double*>(map_->memory + at.offset);
  };
  map_->window = counts(window);
  map_->time = numbers(time);
  map_->seconds = numbers(seconds);
  for (const FieldOffsets& at : input_offsets) {
    map_->inputs.push_back({numbers(at.values), counts(at.shape)});
  }
  for (const FieldOffsets& at : output_offsets) {
    map_->outputs.push_back({numbers(at.values), counts(at.shape)});
  }
  clear_outputs();
}

Slot::~Slot() = default;

void Slot::set_window(const Window& window) {
  window_ = window;
  map_->window[0] = window.index;
  map_->window[1] = window.iteration;
  map_->time[0] = window.begin;
  map_->time[1] = window.end;
}

void Slot::require_whole() const {
  struct stat status {};
  if (::fstat(map_->descriptor, &status) == 0 &&
      status.st_size >= static_cast<off_t>(map_->bytes)) {
    return;
  }
  throw Error::participant(
      fmt::format("participant {}: its slot '{}' was made shorter, from {} to {} bytes",
                  participant_, path_, map_->bytes, status.st_size),
      "a script may change the datasets of its slot, not the file: it must not open it for "
      "writing");
}

void Slot::give(std::size_t input, std::span<const double> values, const Shape& shape) {
  const Place& place = map_->inputs[input];
  std::copy(values.begin(), values.end(), place.values);
  std::copy(shape.begin(), shape.end(), place.shape);
}

Slot::Taken Slot::take(std::size_t output) const {
  const Place& place = map_->outputs[output];
  const Shape& capacity = outputs_[output].capacity;
  if (other_ranks_[output]) return {{}, *other_ranks_[output]};
  Shape shape(place.shape, place.shape + capacity.size());
  // The numbers are the participant's and may be anything: their product might overflow.
  std::int64_t held = 1;
  for (size_t axis = 0; axis < capacity.size(); ++axis) {
    held *= std::clamp<std::int64_t>(shape[axis], 0, capacity[axis]);
  }
  return {{place.values, static_cast<size_t>(held)}, std::move(shape)};
}

void Slot::clear_outputs() {
  for (size_t i = 0; i < outputs_.size(); ++i) {
    std::fill_n(map_->outputs[i].shape, outputs_[i].capacity.size(), std::int64_t{-1});
    other_ranks_[i].reset();
  }
}

double Slot::seconds() const { return *map_->seconds; }

void Slot::write_fresh(const std::string& path) const {
  const std::string temporary = path + ".part";
  hdf5::File file(temporary, hdf5::File::Mode::create);
  describe(file, {}, "file");
  file.write("/window", {2}, std::vector<std::int64_t>{window_.index, window_.iteration});
  file.write("/time", {2}, std::vector<double>{window_.begin, window_.end});
  for (size_t i = 0; i < inputs_.size(); ++i) {
    const Place& place = map_->inputs[i];
    const Shape shape(place.shape, place.shape + inputs_[i].capacity.size());
    const std::string group = "/in/" + inputs_[i].name;
    file.write(group + "/values", shape,
               std::vector<double>(place.values, place.values + hdf5::count_of(shape)));
    file.write(group + "/shape", {static_cast<std::int64_t>(shape.size())}, shape);
    file.set_attribute(group + "/values", "unit", inputs_[i].unit);
  }
  file.close();
  if (std::rename(temporary.c_str(), path.c_str()) != 0) {
    throw_system_error("rename", temporary, errno);
  }
}

void Slot::read_fresh(const std::string& path) {
  clear_outputs();
  const hdf5::File file(path, hdf5::File::Mode::read);
  for (size_t i = 0; i < outputs_.size(); ++i) {
    const std::string group = "/out/" + outputs_[i].name;
    if (!file.exists(group + "/values")) continue;
    const std::vector<double> values = file.read_numbers(group + "/values");
    const Shape shape = file.shape(group + "/values");
    const Place& place = map_->outputs[i];
    const size_t rank = outputs_[i].capacity.size();
    const auto capacity = static_cast<size_t>(hdf5::count_of(outputs_[i].capacity));
    std::copy_n(values.begin(), std::min(values.size(), capacity), place.values);
    if (shape.size() == rank) {
      std::copy(shape.begin(), shape.end(), place.shape);
    } else {
      other_ranks_[i] = shape;
    }
  }
  if (!file.exists("/seconds")) return;
  const std::vector<double> seconds = file.read_numbers("/seconds");
  *map_->seconds = seconds.empty() ? 0 : seconds.front();
}

}  // namespace sandglass::exchange
