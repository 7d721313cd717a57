#include "slot.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "hdf5_file.hpp"

namespace sandglass {

namespace {

using hdf5_file::Handle;

std::vector<std::string> names_in(hid_t file, const std::string& group) {
  std::vector<std::string> names;
  if (H5Lexists(file, group.c_str(), H5P_DEFAULT) <= 0) return names;
  const Handle handle(H5Gopen2(file, group.c_str(), H5P_DEFAULT), H5Gclose);
  H5Literate(
      handle.id(), H5_INDEX_NAME, H5_ITER_INC, nullptr,
      [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
        static_cast<std::vector<std::string>*>(out)->push_back(name);
        return 0;
      },
      &names);
  return names;
}

/// The address of a dataset's bytes in the mapped file.
template <class Number>
Number* place(hid_t file, const std::string& path, const std::string& dataset, hid_t type,
              char* base, std::size_t size) {
  const Handle handle = hdf5_file::open_dataset(file, path, dataset);
  const Handle stored(H5Dget_type(handle.id()), H5Tclose);
  if (H5Tequal(stored.id(), type) <= 0)
    throw std::runtime_error("dataset '" + dataset + "' of the slot " + path +
                             " has an unexpected number type");
  const auto bytes =
      sizeof(Number) * static_cast<std::size_t>(hdf5_file::count(hdf5_file::shape_of(handle.id())));
  const haddr_t offset = H5Dget_offset(handle.id());
  if (bytes == 0) return reinterpret_cast<Number*>(base);  // never touched
  if (offset == HADDR_UNDEF || offset + bytes > size)
    throw std::runtime_error("dataset '" + dataset + "' of the slot " + path +
                             " is not contiguous and allocated early: its place could move");
  return reinterpret_cast<Number*>(base + offset);
}

const Slot::Field& find(const std::map<std::string, Slot::Field>& fields, const std::string& name,
                        const std::string& direction) {
  const auto found = fields.find(name);
  if (found != fields.end()) return found->second;
  std::string known;
  for (const auto& [other, field] : fields) known += (known.empty() ? "" : ", ") + other;
  throw std::runtime_error("this participant " + direction + " no field '" + name +
                           "'; the workflow names: " + (known.empty() ? "none" : known));
}

}  // namespace

Slot::Slot(const std::string& path) {
  if (hdf5_file::text_attribute(path, "/", "filetype") != "sandglass slot")
    throw std::runtime_error(path + " is not a slot (attribute 'filetype')");
  const bool wanted = hdf5_file::text_attribute(path, "/", "transport") == "mapped";
  if (wanted) map(path);

  const Handle file = hdf5_file::open_file(path);
  const auto fields = [&](const std::string& group) {
    std::map<std::string, Field> found;
    for (const std::string& name : names_in(file.id(), group)) {
      const std::string stem = std::string(group).append("/").append(name);
      const std::string values = stem + "/values";
      const std::string shape = stem + "/shape";
      Field field;
      field.capacity = hdf5_file::shape_of(hdf5_file::open_dataset(file.id(), path, values).id());
      field.unit = hdf5_file::text_attribute(path, values, "unit");
      if (wanted) {
        field.values = place<double>(file.id(), path, values, H5T_IEEE_F64LE, base_, size_);
        field.shape = place<std::int64_t>(file.id(), path, shape, H5T_STD_I64LE, base_, size_);
      }
      found.emplace(name, field);
    }
    return found;
  };
  in_ = fields("/in");
  out_ = fields("/out");
  if (!wanted) return;
  window_ = place<std::int64_t>(file.id(), path, "/window", H5T_STD_I64LE, base_, size_);
  time_ = place<double>(file.id(), path, "/time", H5T_IEEE_F64LE, base_, size_);
  seconds_ = place<double>(file.id(), path, "/seconds", H5T_IEEE_F64LE, base_, size_);
}

Slot::~Slot() {
  if (base_ != nullptr) munmap(base_, size_);
}

void Slot::map(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDWR | O_CLOEXEC);
  struct stat status {};
  void* address = MAP_FAILED;
  if (descriptor >= 0 && fstat(descriptor, &status) == 0)
    address = mmap(nullptr, static_cast<std::size_t>(status.st_size), PROT_READ | PROT_WRITE,
                   MAP_SHARED, descriptor, 0);
  const std::string reason = std::strerror(errno);
  if (descriptor >= 0) close(descriptor);
  if (address == MAP_FAILED)
    throw std::runtime_error("cannot map the slot " + path + ": " + reason);
  base_ = static_cast<char*>(address);
  size_ = static_cast<std::size_t>(status.st_size);
}

const Slot::Field& Slot::in(const std::string& field) const { return find(in_, field, "receives"); }
const Slot::Field& Slot::out(const std::string& field) const { return find(out_, field, "sends"); }

std::vector<std::int64_t> shape_sent(const std::vector<std::int64_t>& capacity,
                                     std::int64_t length) {
  std::vector<std::int64_t> shape = capacity;
  if (shape.empty()) return shape;
  const std::int64_t row = hdf5_file::count({capacity.begin() + 1, capacity.end()});
  if (row > 0 && length % row == 0) {
    shape[0] = length / row;
  } else {
    shape.assign(capacity.size(), 1);
    shape[0] = length;
  }
  return shape;
}

}  // namespace sandglass
