#pragma once

#include <string>
#include <string_view>

namespace sandglass {

/// The whole file. Throws Error::environment when it cannot be read.
std::string read_file(const std::string& path);

/// Throws Error::usage when there is no such file, or it is no regular one (a folder, a device, a
/// pipe: reading could wait, or go on, for ever).
void require_regular_file(const std::string& path);

/// Writes under another name, flushes to the disk, then renames: a reader (or a power cut) finds
/// the old text or the new one, never a part. Throws Error::environment.
void write_file(const std::string& path, std::string_view text);

/// Makes the folder and its parents. Throws Error::environment.
void make_directories(const std::string& path);

/// SHA-256 as 64 hexadecimal digits.
std::string digest_of_text(std::string_view text);
/// The same of a file's bytes. Throws Error::environment when it cannot be read.
std::string digest_of_file(const std::string& path);

/// Where the program `name` is found on PATH; empty when it is not. A name with a slash is returned
/// as it is when it can be executed.
std::string find_program(const std::string& name);

/// What to do about an errno; empty where there is nothing general to say.
std::string remedy_for(int number);

/// Error::environment for a failed system call on a path, with what errno means and what to do.
[[noreturn]] void throw_system_error(const std::string& doing, const std::string& path, int number);

}  // namespace sandglass
