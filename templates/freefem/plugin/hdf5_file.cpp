#include "hdf5_file.hpp"

#include <unistd.h>

#include <stdexcept>
#include <type_traits>

namespace sandglass::hdf5_file {

namespace {

/// HDF5 prints its error stack by itself unless told otherwise; the reason goes into our message.
std::string reason() {
  std::string text;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_DOWNWARD,
      [](unsigned depth, const H5E_error2_t* error, void* out) -> herr_t {
        if (depth == 0 && error->desc != nullptr) *static_cast<std::string*>(out) = error->desc;
        return 0;
      },
      &text);
  H5Eclear2(H5E_DEFAULT);
  return text.empty() ? "" : " (HDF5: " + text + ")";
}

[[noreturn]] void fail(const std::string& what, const std::string& path,
                       const std::string& object) {
  throw std::runtime_error(what + (object.empty() ? "" : " '" + object + "' of") +
                           " the HDF5 file " + path + reason());
}

void be_quiet() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

/// Locks are of no use here (files are complete before anyone is told of them) and fail on some
/// network disks.
Handle without_locks() {
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_file_locking(access.id(), false, true);
  return access;
}

Handle open_for_writing(const std::string& path) {
  be_quiet();
  const Handle access = without_locks();
  const bool there = ::access(path.c_str(), F_OK) == 0;
  Handle file(there ? H5Fopen(path.c_str(), H5F_ACC_RDWR, access.id())
                    : H5Fcreate(path.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, access.id()),
              H5Fclose);
  if (file.id() < 0) fail(there ? "cannot write to" : "cannot make", path, "");
  return file;
}

Handle open_object(const Handle& file, const std::string& path, const std::string& object) {
  Handle handle(H5Oopen(file.id(), object.c_str(), H5P_DEFAULT), H5Oclose);
  if (handle.id() < 0) fail("cannot find", path, object);
  return handle;
}

/// Whether every link on the way to the object is there (HDF5 asks for one step at a time).
bool linked(hid_t file, const std::string& object) {
  for (std::size_t end = object.find('/', 1);; end = object.find('/', end + 1)) {
    const std::string step = object.substr(0, end);
    if (step != "/" && H5Lexists(file, step.c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) return true;
  }
}

template <class Number>
hid_t memory_type() {
  static_assert(std::is_same_v<Number, double> || std::is_same_v<Number, std::int64_t>);
  return std::is_same_v<Number, double> ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64;
}

template <class Number>
hid_t file_type() {
  return std::is_same_v<Number, double> ? H5T_IEEE_F64LE : H5T_STD_I64LE;
}

/// Replaces the attribute by a scalar one of the given types.
void put_attribute(const std::string& path, const std::string& object, const std::string& name,
                   hid_t stored, hid_t memory, const void* value) {
  const Handle file = open_for_writing(path);
  const Handle owner = open_object(file, path, object);
  if (H5Aexists(owner.id(), name.c_str()) > 0) H5Adelete(owner.id(), name.c_str());
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(
      H5Acreate2(owner.id(), name.c_str(), stored, space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (attribute.id() < 0 || H5Awrite(attribute.id(), memory, value) < 0)
    fail("cannot write attribute '" + name + "' of", path, object);
}

}  // namespace

std::int64_t count(const std::vector<std::int64_t>& shape) {
  std::int64_t product = 1;
  for (const std::int64_t length : shape) product *= length;
  return product;
}

Handle open_file(const std::string& path) {
  be_quiet();
  const Handle access = without_locks();
  Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.id()), H5Fclose);
  if (file.id() < 0) fail("cannot open", path, "");
  return file;
}

Handle open_dataset(hid_t file, const std::string& path, const std::string& dataset) {
  Handle handle(H5Dopen2(file, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (handle.id() < 0) fail("cannot open dataset", path, dataset);
  return handle;
}

std::vector<std::int64_t> shape_of(hid_t dataset) {
  const Handle space(H5Dget_space(dataset), H5Sclose);
  std::vector<hsize_t> lengths(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space.id())));
  H5Sget_simple_extent_dims(space.id(), lengths.data(), nullptr);
  return {lengths.begin(), lengths.end()};
}

template <class Number>
Array<Number> read(const std::string& path, const std::string& dataset) {
  const Handle file = open_file(path);
  const Handle source = open_dataset(file.id(), path, dataset);
  Array<Number> array;
  array.shape = shape_of(source.id());
  array.values.resize(static_cast<std::size_t>(count(array.shape)));
  if (H5Dread(source.id(), memory_type<Number>(), H5S_ALL, H5S_ALL, H5P_DEFAULT,
              array.values.data()) < 0)
    fail("cannot read numbers from dataset", path, dataset);
  return array;
}

template <class Number>
void write(const std::string& path, const std::string& dataset, const Array<Number>& array) {
  const Handle file = open_for_writing(path);
  if (linked(file.id(), dataset)) H5Ldelete(file.id(), dataset.c_str(), H5P_DEFAULT);
  const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(links.id(), 1);
  const std::vector<hsize_t> lengths(array.shape.begin(), array.shape.end());
  const Handle space(H5Screate_simple(static_cast<int>(lengths.size()), lengths.data(), nullptr),
                     H5Sclose);
  const Handle target(H5Dcreate2(file.id(), dataset.c_str(), file_type<Number>(), space.id(),
                                 links.id(), H5P_DEFAULT, H5P_DEFAULT),
                      H5Dclose);
  if (target.id() < 0 || H5Dwrite(target.id(), memory_type<Number>(), H5S_ALL, H5S_ALL, H5P_DEFAULT,
                                  array.values.data()) < 0)
    fail("cannot write dataset", path, dataset);
  // Contents reach the disk at the flush at the latest: a full disk is found here, not by a reader.
  if (H5Fflush(file.id(), H5F_SCOPE_LOCAL) < 0) fail("cannot write dataset", path, dataset);
}

template Array<double> read(const std::string&, const std::string&);
template Array<std::int64_t> read(const std::string&, const std::string&);
template void write(const std::string&, const std::string&, const Array<double>&);
template void write(const std::string&, const std::string&, const Array<std::int64_t>&);

bool exists(const std::string& path, const std::string& object) {
  if (::access(path.c_str(), F_OK) != 0) return false;
  const Handle file = open_file(path);
  return linked(file.id(), object);
}

double number_attribute(const std::string& path, const std::string& object,
                        const std::string& name) {
  const Handle file = open_file(path);
  const Handle owner = open_object(file, path, object);
  const Handle attribute(H5Aopen(owner.id(), name.c_str(), H5P_DEFAULT), H5Aclose);
  if (attribute.id() < 0) fail("cannot find attribute '" + name + "' of", path, object);
  const Handle space(H5Aget_space(attribute.id()), H5Sclose);
  double value = 0;
  if (H5Sget_simple_extent_npoints(space.id()) != 1)
    fail("more than one number in attribute '" + name + "' of", path, object);
  if (H5Aread(attribute.id(), H5T_NATIVE_DOUBLE, &value) < 0)
    fail("no number in attribute '" + name + "' of", path, object);
  return value;
}

std::string text_attribute(const std::string& path, const std::string& object,
                           const std::string& name) {
  const Handle file = open_file(path);
  const Handle owner = open_object(file, path, object);
  const Handle attribute(H5Aopen(owner.id(), name.c_str(), H5P_DEFAULT), H5Aclose);
  if (attribute.id() < 0) fail("cannot find attribute '" + name + "' of", path, object);
  const Handle stored(H5Aget_type(attribute.id()), H5Tclose);
  const Handle space(H5Aget_space(attribute.id()), H5Sclose);
  if (H5Tget_class(stored.id()) != H5T_STRING || H5Sget_simple_extent_npoints(space.id()) != 1)
    fail("no text in attribute '" + name + "' of", path, object);
  if (H5Tis_variable_str(stored.id()) > 0) {
    char* value = nullptr;
    if (H5Aread(attribute.id(), stored.id(), &value) < 0 || value == nullptr)
      fail("cannot read attribute '" + name + "' of", path, object);
    std::string text = value;
    H5free_memory(value);
    return text;
  }
  std::string text(H5Tget_size(stored.id()), '\0');
  if (H5Aread(attribute.id(), stored.id(), text.data()) < 0)
    fail("cannot read attribute '" + name + "' of", path, object);
  return text.c_str();  // up to the padding
}

void set_attribute(const std::string& path, const std::string& object, const std::string& name,
                   double value) {
  put_attribute(path, object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

void set_attribute(const std::string& path, const std::string& object, const std::string& name,
                   const std::string& value) {
  const Handle text(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(text.id(), value.size() + 1);
  H5Tset_cset(text.id(), H5T_CSET_UTF8);
  put_attribute(path, object, name, text.id(), text.id(), value.c_str());
}

}  // namespace sandglass::hdf5_file
