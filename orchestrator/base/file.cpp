#include "base/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <sstream>

#include "base/error.hpp"

namespace sandglass {
namespace {

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int number() const { return number_; }
  int close() {
    const int result = ::close(number_);
    number_ = -1;
    return result;
  }

 private:
  int number_;
};

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr);
  }
  void add(const void* bytes, size_t count) { EVP_DigestUpdate(context_.get(), bytes, count); }
  std::string hexadecimal() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
    unsigned int count = 0;
    EVP_DigestFinal_ex(context_.get(), bytes.data(), &count);
    std::string text;
    for (unsigned int i = 0; i < count; ++i) text += fmt::format("{:02x}", bytes.at(i));
    return text;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

/// Calls `use(bytes, count)` for the file, block by block.
template <typename Use>
void each_block(const std::string& path, Use use) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.number() < 0) throw_system_error("read", path, errno);
  std::array<char, size_t{1} << 16> block{};
  for (;;) {
    const ssize_t count = ::read(file.number(), block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw_system_error("read", path, errno);
    if (count == 0) return;
    use(block.data(), static_cast<size_t>(count));
  }
}

}  // namespace

std::string remedy_for(int number) {
  switch (number) {
    case ENOSPC:
    case EDQUOT:
      return "the disk is full: free some space or choose another place with --out";
    case EFBIG:
      return "a limit on the size of files is reached: raise it (ulimit -f) or choose another "
             "place "
             "with --out";
    case EACCES:
    case EPERM:
    case EROFS:
      return "check the permissions or choose another place with --out";
    default:
      return {};
  }
}

void throw_system_error(const std::string& doing, const std::string& path, int number) {
  throw Error::environment(fmt::format("cannot {} '{}': {}", doing, path, std::strerror(number)),
                           remedy_for(number));
}

std::string read_file(const std::string& path) {
  std::string text;
  each_block(path, [&](const char* bytes, size_t count) { text.append(bytes, count); });
  return text;
}

void require_regular_file(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_regular_file(path, error)) return;
  if (std::filesystem::exists(path, error)) {
    throw Error::usage(fmt::format("'{}' is not a regular file", path), "name a file");
  }
  throw Error::usage(fmt::format("there is no file '{}'", path), "check the path");
}

void write_file(const std::string& path, std::string_view text) {
  const std::string temporary = path + ".part";
  Descriptor file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (file.number() < 0) throw_system_error("write", temporary, errno);
  while (!text.empty()) {
    const ssize_t count = ::write(file.number(), text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      const int number = errno;
      ::unlink(temporary.c_str());
      throw_system_error("write", path, number);
    }
    text.remove_prefix(static_cast<size_t>(count));
  }
  if (::fsync(file.number()) != 0 || file.close() != 0) {
    const int number = errno;
    ::unlink(temporary.c_str());
    throw_system_error("write", path, number);
  }
  if (::rename(temporary.c_str(), path.c_str()) != 0) throw_system_error("write", path, errno);
}

void make_directories(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw_system_error("make the folder", path, error.value());
}

std::string digest_of_text(std::string_view text) {
  Sha256 digest;
  digest.add(text.data(), text.size());
  return digest.hexadecimal();
}

std::string digest_of_file(const std::string& path) {
  Sha256 digest;
  each_block(path, [&](const char* bytes, size_t count) { digest.add(bytes, count); });
  return digest.hexadecimal();
}

std::string find_program(const std::string& name) {
  if (name.find('/') != std::string::npos) {
    return ::access(name.c_str(), X_OK) == 0 ? name : std::string();
  }
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "/usr/local/bin:/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::string candidate = folder + "/" + name;
    std::error_code error;
    if (std::filesystem::is_regular_file(candidate, error) &&
        ::access(candidate.c_str(), X_OK) == 0) {
      return candidate;
    }
  }
  return {};
}

}  // namespace sandglass
