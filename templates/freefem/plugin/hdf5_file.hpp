#pragma once

#include <hdf5.h>

#include <cstdint>
#include <string>
#include <vector>

/// The little of HDF5 that a FreeFEM script and the participant protocol need. Every function opens
/// the file and closes it again; every failure is a std::runtime_error that names the file, the
/// object and HDF5's own reason.
namespace sandglass::hdf5_file {

/// An HDF5 identifier that is closed when it goes out of scope.
class Handle {
 public:
  using Closer = herr_t (*)(hid_t);
  Handle(hid_t id, Closer closer) : id_(id), closer_(closer) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  Handle(Handle&& other) noexcept : id_(other.id_), closer_(other.closer_) { other.id_ = -1; }
  ~Handle() {
    if (id_ >= 0) closer_(id_);
  }
  [[nodiscard]] hid_t id() const { return id_; }

 private:
  hid_t id_;
  Closer closer_;
};

/// A dataset's shape and its values, row by row.
template <class Number>  // double or std::int64_t
struct Array {
  std::vector<std::int64_t> shape;
  std::vector<Number> values;
};

/// How many values an array of this shape holds; 1 for a scalar (no axis).
std::int64_t count(const std::vector<std::int64_t>& shape);

Handle open_file(const std::string& path);
Handle open_dataset(hid_t file, const std::string& path, const std::string& dataset);
std::vector<std::int64_t> shape_of(hid_t dataset);

/// Reads a dataset of any number type.
template <class Number>
Array<Number> read(const std::string& path, const std::string& dataset);

/// Writes a dataset; makes the file and the groups above when they are missing, and replaces an
/// older dataset of that name.
template <class Number>
void write(const std::string& path, const std::string& dataset, const Array<Number>& array);

/// Whether the file is there and holds that dataset or group.
bool exists(const std::string& path, const std::string& object);

double number_attribute(const std::string& path, const std::string& object,
                        const std::string& name);
std::string text_attribute(const std::string& path, const std::string& object,
                           const std::string& name);
void set_attribute(const std::string& path, const std::string& object, const std::string& name,
                   double value);
void set_attribute(const std::string& path, const std::string& object, const std::string& name,
                   const std::string& value);

}  // namespace sandglass::hdf5_file
