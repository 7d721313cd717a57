#include "hdf5/hdf5.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <functional>
#include <numeric>
#include <utility>

#include "base/error.hpp"
#include "base/file.hpp"

namespace sandglass::hdf5 {
namespace {

herr_t collect(unsigned /*level*/, const H5E_error2_t* entry, void* text) {
  auto& all = *static_cast<std::string*>(text);
  if (entry->desc == nullptr || *entry->desc == '\0') return 0;
  if (!all.empty()) all += ", ";
  all += entry->desc;
  return 0;
}

/// HDF5 gives the operating system's reason as text only.
std::string remedy_in(const std::string& reasons) {
  for (const int number : {ENOSPC, EDQUOT, EFBIG, EACCES, EPERM, EROFS}) {
    if (reasons.find(std::strerror(number)) != std::string::npos) return remedy_for(number);
  }
  return {};
}

[[noreturn]] void fail(const std::string& doing, const std::string& path) {
  std::string reasons;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, collect, &reasons);
  H5Eclear2(H5E_DEFAULT);
  // Some of HDF5's texts bring their own line end.
  std::replace(reasons.begin(), reasons.end(), '\n', ' ');
  throw Error::environment(fmt::format("HDF5 file '{}': cannot {}: {}", path, doing, reasons),
                           remedy_in(reasons));
}

using Closer = herr_t (*)(hid_t);

/// Owns one identifier.
class Handle {
 public:
  Handle(hid_t id, Closer closer, const std::string& doing, const std::string& path)
      : id_(id), closer_(closer) {
    if (id_ < 0) fail(doing, path);
  }
  ~Handle() {
    if (id_ >= 0) closer_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }  // NOLINT: the one place where a handle is a number

 private:
  hid_t id_;
  Closer closer_;
};

void require(herr_t status, const std::string& doing, const std::string& path) {
  if (status < 0) fail(doing, path);
}

hid_t type_of(Type type) { return type == Type::float64 ? H5T_IEEE_F64LE : H5T_STD_I64LE; }

std::vector<hsize_t> extents(const Shape& shape) {
  std::vector<hsize_t> result(shape.size());
  std::transform(shape.begin(), shape.end(), result.begin(),
                 [](std::int64_t n) { return static_cast<hsize_t>(n); });
  return result;
}

void quiet() {
  static const bool done = [] {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    return true;
  }();
  static_cast<void>(done);
}

Handle create_dataset(hid_t file, const std::string& path, const std::string& name, hid_t type,
                      const Shape& shape) {
  const auto size = extents(shape);
  const Handle space(H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr),
                     H5Sclose, "describe the shape of " + name, path);
  const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose, "create " + name, path);
  H5Pset_create_intermediate_group(links, 1);
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "create " + name, path);
  H5Pset_layout(creation, H5D_CONTIGUOUS);
  H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY);
  H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER);
  // Checked here: closing the handles above would erase HDF5's account of a failure.
  return {H5Dcreate2(file, name.c_str(), type, space, links, creation, H5P_DEFAULT), H5Dclose,
          "create " + name, path};
}

template <typename Number>
void write_dataset(hid_t file, const std::string& path, const std::string& name, Type type,
                   hid_t memory, const Shape& shape, const std::vector<Number>& values) {
  if (count_of(shape) != static_cast<std::int64_t>(values.size())) {
    throw Error::environment(fmt::format("{} values for dataset {} of {} in '{}'", values.size(),
                                         name, count_of(shape), path));
  }
  const Handle dataset = create_dataset(file, path, name, type_of(type), shape);
  if (values.empty()) return;
  require(H5Dwrite(dataset, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "write " + name,
          path);
}

template <typename Number>
std::vector<Number> read_dataset(hid_t file, const std::string& path, const std::string& name,
                                 hid_t memory, std::int64_t rows) {
  const std::string doing = "read " + name;
  const Handle dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose, doing, path);
  const Handle space(H5Dget_space(dataset), H5Sclose, doing, path);
  std::vector<hsize_t> size(static_cast<size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
  H5Sget_simple_extent_dims(space, size.data(), nullptr);
  if (rows >= 0 && !size.empty()) {
    size[0] = std::min(size[0], static_cast<hsize_t>(rows));
    const std::vector<hsize_t> start(size.size(), 0);
    require(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, size.data(), nullptr),
            doing, path);
  }
  std::vector<Number> values(
      std::accumulate(size.begin(), size.end(), size_t{1}, std::multiplies<>()));
  if (values.empty()) return values;
  const Handle target(H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr),
                      H5Sclose, doing, path);
  require(H5Dread(dataset, memory, target, space, H5P_DEFAULT, values.data()), doing, path);
  return values;
}

void remove_attribute(hid_t object, const std::string& attribute) {
  if (H5Aexists(object, attribute.c_str()) > 0) H5Adelete(object, attribute.c_str());
}

}  // namespace

std::int64_t count_of(const Shape& shape) {
  std::int64_t count = 1;
  for (const std::int64_t n : shape) count *= n;
  return count;
}

File::File(std::string path, Mode mode) : path_(std::move(path)) {
  quiet();
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "prepare opening it", path_);
#if H5_VERSION_GE(1, 10, 7)
  H5Pset_file_locking(access, false, true);
#endif
  if (mode == Mode::create) {
    // Numbers that are used in place, through a memory map, must start where the processor likes.
    H5Pset_alignment(access, 8, 64);
    handle_ = H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  } else {
    handle_ = H5Fopen(path_.c_str(), mode == Mode::read ? H5F_ACC_RDONLY : H5F_ACC_RDWR, access);
  }
  if (handle_ < 0) fail(mode == Mode::create ? "create it" : "open it", path_);
}

File::~File() {
  if (handle_ >= 0) H5Fclose(handle_);
}

void File::close() {
  if (handle_ < 0) return;
  const hid_t handle = std::exchange(handle_, -1);
  require(H5Fclose(handle), "close it", path_);
}

Location File::reserve(const std::string& name, Type type, const Shape& shape) {
  const Handle dataset = create_dataset(handle_, path_, name, type_of(type), shape);
  if (count_of(shape) == 0) return {};
  const haddr_t offset = H5Dget_offset(dataset);
  if (offset == HADDR_UNDEF) fail("place " + name, path_);
  return {offset, static_cast<std::uint64_t>(count_of(shape)) * 8};
}

Location File::location(const std::string& name) const {
  const std::string doing = "read " + name;
  const Handle dataset(H5Dopen2(handle_, name.c_str(), H5P_DEFAULT), H5Dclose, doing, path_);
  const std::uint64_t bytes = H5Dget_storage_size(dataset);
  if (bytes == 0) return {};
  const haddr_t offset = H5Dget_offset(dataset);
  if (offset == HADDR_UNDEF) fail("find the place of " + name, path_);
  return {offset, bytes};
}

void File::write(const std::string& name, const Shape& shape, const std::vector<double>& values) {
  write_dataset(handle_, path_, name, Type::float64, H5T_NATIVE_DOUBLE, shape, values);
}

void File::write(const std::string& name, const Shape& shape,
                 const std::vector<std::int64_t>& values) {
  write_dataset(handle_, path_, name, Type::int64, H5T_NATIVE_INT64, shape, values);
}

bool File::exists(const std::string& name) const {
  // Every part of the way must be asked for: HDF5 fails on a missing parent.
  for (size_t slash = name.find('/', 1);; slash = name.find('/', slash + 1)) {
    const std::string part = name.substr(0, slash);
    if (H5Lexists(handle_, part.c_str(), H5P_DEFAULT) <= 0) return false;
    if (slash == std::string::npos) return true;
  }
}

Shape File::shape(const std::string& name) const {
  const Handle dataset(H5Dopen2(handle_, name.c_str(), H5P_DEFAULT), H5Dclose, "open " + name,
                       path_);
  const Handle space(H5Dget_space(dataset), H5Sclose, "read " + name, path_);
  std::vector<hsize_t> size(static_cast<size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
  H5Sget_simple_extent_dims(space, size.data(), nullptr);
  return {size.begin(), size.end()};
}

std::vector<double> File::read_numbers(const std::string& name, std::int64_t rows) const {
  return read_dataset<double>(handle_, path_, name, H5T_NATIVE_DOUBLE, rows);
}

std::vector<std::int64_t> File::read_counts(const std::string& name, std::int64_t rows) const {
  return read_dataset<std::int64_t>(handle_, path_, name, H5T_NATIVE_INT64, rows);
}

std::vector<std::string> File::list(const std::string& group) const {
  std::vector<std::string> names;
  const auto add = [](hid_t, const char* name, const H5L_info_t*, void* all) -> herr_t {
    static_cast<std::vector<std::string>*>(all)->emplace_back(name);
    return 0;
  };
  require(H5Literate_by_name(handle_, group.c_str(), H5_INDEX_NAME, H5_ITER_INC, nullptr, add,
                             &names, H5P_DEFAULT),
          "list " + group, path_);
  return names;
}

void File::set_attribute(const std::string& name, const std::string& attribute,
                         const std::string& text) {
  const Handle object(H5Oopen(handle_, name.c_str(), H5P_DEFAULT), H5Oclose, "open " + name, path_);
  remove_attribute(object, attribute);
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "write attribute " + attribute, path_);
  H5Tset_size(type, std::max<size_t>(1, text.size()));
  H5Tset_cset(type, H5T_CSET_UTF8);
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose, "write attribute " + attribute, path_);
  const Handle created(H5Acreate2(object, attribute.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT),
                       H5Aclose, "write attribute " + attribute, path_);
  require(H5Awrite(created, type, text.empty() ? "" : text.data()), "write attribute " + attribute,
          path_);
}

void File::set_attribute(const std::string& name, const std::string& attribute,
                         const std::vector<std::int64_t>& numbers) {
  const Handle object(H5Oopen(handle_, name.c_str(), H5P_DEFAULT), H5Oclose, "open " + name, path_);
  remove_attribute(object, attribute);
  const hsize_t size = numbers.size();
  const Handle space(
      numbers.size() == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &size, nullptr), H5Sclose,
      "write attribute " + attribute, path_);
  const Handle created(
      H5Acreate2(object, attribute.c_str(), H5T_STD_I64LE, space, H5P_DEFAULT, H5P_DEFAULT),
      H5Aclose, "write attribute " + attribute, path_);
  require(H5Awrite(created, H5T_NATIVE_INT64, numbers.data()), "write attribute " + attribute,
          path_);
}

std::string File::text_attribute(const std::string& name, const std::string& attribute) const {
  const Handle object(H5Oopen(handle_, name.c_str(), H5P_DEFAULT), H5Oclose, "open " + name, path_);
  const Handle opened(H5Aopen(object, attribute.c_str(), H5P_DEFAULT), H5Aclose,
                      "read attribute " + attribute, path_);
  const Handle stored(H5Aget_type(opened), H5Tclose, "read attribute " + attribute, path_);
  if (H5Tget_class(stored) != H5T_STRING || H5Tis_variable_str(stored) > 0) {
    throw Error::environment(fmt::format("attribute '{}' of {} in '{}' is not a text of fixed size",
                                         attribute, name, path_));
  }
  std::string text(H5Tget_size(stored), '\0');
  require(H5Aread(opened, stored, text.data()), "read attribute " + attribute, path_);
  text.resize(std::min(text.find('\0'), text.size()));
  return text;
}

std::vector<std::int64_t> File::count_attribute(const std::string& name,
                                                const std::string& attribute) const {
  const Handle object(H5Oopen(handle_, name.c_str(), H5P_DEFAULT), H5Oclose, "open " + name, path_);
  const Handle opened(H5Aopen(object, attribute.c_str(), H5P_DEFAULT), H5Aclose,
                      "read attribute " + attribute, path_);
  const Handle space(H5Aget_space(opened), H5Sclose, "read attribute " + attribute, path_);
  std::vector<std::int64_t> numbers(
      static_cast<size_t>(std::max<hssize_t>(1, H5Sget_simple_extent_npoints(space))));
  require(H5Aread(opened, H5T_NATIVE_INT64, numbers.data()), "read attribute " + attribute, path_);
  return numbers;
}

std::string library_version() {
  std::array<unsigned, 3> number{};
  H5get_libversion(number.data(), &number[1], &number[2]);
  return fmt::format("{}.{}.{}", number[0], number[1], number[2]);
}

}  // namespace sandglass::hdf5
