#include "participant.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <stdexcept>

namespace sandglass {
namespace {

const char* environment(const char* name) {
  const char* value = std::getenv(name);
  if (value == nullptr)
    throw std::runtime_error(
        std::string(name) +
        " is not set: this script is a participant and is started by sandglass");
  return value;
}

int descriptor(const char* name) {
  const char* text = environment(name);
  char* end = nullptr;
  const long number = std::strtol(text, &end, 10);
  if (end == text || *end != '\0' || number < 0)
    throw std::runtime_error(std::string(name) + " = '" + text + "' is no file descriptor");
  return static_cast<int>(number);
}

}  // namespace

double monotonic_seconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Participant::Participant(int commands, int replies, const std::string& slot)
    : commands_(commands), replies_(replies), slot_(slot) {}

std::unique_ptr<Participant> Participant::from_environment() {
  return std::make_unique<Participant>(descriptor("SANDGLASS_COMMANDS"),
                                       descriptor("SANDGLASS_REPLIES"),
                                       environment("SANDGLASS_SLOT"));
}

void Participant::ready(const std::string& abilities) {
  write_line(abilities.empty() ? "ready 1" : "ready 1 " + abilities);
}

std::string Participant::next() {
  if (!command_.empty())
    throw std::logic_error("the command '" + command_ + "' was not answered (sandglassDone)");
  std::string line;
  if (!read_line(line)) return "";
  began_ = monotonic_seconds();
  const std::size_t space = line.find(' ');
  command_ = line.substr(0, space);
  const std::string arguments = space == std::string::npos ? "" : line.substr(space + 1);
  path_.clear();
  in_file_.clear();
  out_file_.clear();
  if (command_ == "advance") {
    begin_files(arguments);
    sent_.clear();
    has_sent_.clear();
  } else if (command_ == "checkpoint" || command_ == "load") {
    path_ = arguments;
  } else if (command_ != "save" && command_ != "restore" && command_ != "stop") {
    throw std::runtime_error("a FreeFEM script does not know the command '" + command_ + "'");
  }
  return command_;
}

void Participant::begin_files(const std::string& arguments) {
  if (arguments.empty()) {
    if (!slot_.mapped())
      throw std::runtime_error("'advance' came without files, but the slot is not mapped");
    return;
  }
  // A space within IN is told from the one behind it by the file being there.
  for (std::size_t space = arguments.find(' '); space != std::string::npos;
       space = arguments.find(' ', space + 1)) {
    if (access(arguments.substr(0, space).c_str(), R_OK) != 0) continue;
    in_file_ = arguments.substr(0, space);
    out_file_ = arguments.substr(space + 1);
    return;
  }
  throw std::runtime_error("no such file to read fields from: 'advance " + arguments + "'");
}

Participant::Array Participant::receive(const std::string& field) const {
  const Slot::Field& source = slot_.in(field);
  if (command_ != "advance")
    throw std::logic_error("the field '" + field + "' can be received within 'advance' only");
  if (!in_file_.empty()) return hdf5_file::read<double>(in_file_, "/in/" + field + "/values");
  Array array;
  array.shape.assign(source.shape, source.shape + source.capacity.size());
  for (std::size_t axis = 0; axis < array.shape.size(); ++axis) {
    if (array.shape[axis] < 0 || array.shape[axis] > source.capacity[axis])
      throw std::runtime_error("the field '" + field + "' claims a length of " +
                               std::to_string(array.shape[axis]) + "; the slot holds " +
                               std::to_string(source.capacity[axis]));
  }
  array.values.assign(source.values, source.values + hdf5_file::count(array.shape));
  return array;
}

void Participant::send(const std::string& field, const Array& array) {
  const Slot::Field& target = slot_.out(field);
  if (command_ != "advance")
    throw std::logic_error("the field '" + field + "' can be sent within 'advance' only");
  if (array.shape.size() != target.capacity.size())
    throw std::runtime_error("the field '" + field + "' has " +
                             std::to_string(target.capacity.size()) + " axes, the array sent has " +
                             std::to_string(array.shape.size()));
  has_sent_[field] = true;
  if (!out_file_.empty()) {
    sent_[field] = array;
    return;
  }
  const auto room = static_cast<std::size_t>(hdf5_file::count(target.capacity));
  std::copy_n(array.values.begin(), std::min(array.values.size(), room), target.values);
  std::copy(array.shape.begin(), array.shape.end(), target.shape);
}

void Participant::send(const std::string& field, std::vector<double> values) {
  Array array;
  array.shape = shape_sent(slot_.out(field).capacity, static_cast<std::int64_t>(values.size()));
  array.values = std::move(values);
  send(field, array);
}

void Participant::done() {
  if (command_.empty()) throw std::logic_error("there is no command to answer (sandglassDone)");
  if (command_ == "advance") {
    for (const auto& [name, field] : slot_.all_out())
      if (!has_sent_[name])
        throw std::runtime_error("the script did not send the field '" + name + "' in this window");
  }
  const double seconds = monotonic_seconds() - began_;
  if (slot_.mapped()) *slot_.seconds() = seconds;
  if (!out_file_.empty()) write_files(seconds);
  command_.clear();
  write_line("ok");
}

void Participant::write_files(double seconds) const {
  const std::string part = out_file_ + ".part";
  std::remove(part.c_str());
  hdf5_file::write<std::int64_t>(part, "/window", {{2}, {window(0), window(1)}});
  hdf5_file::write<double>(part, "/time", {{2}, {time(0), time(1)}});
  for (const auto& [name, array] : sent_) {
    const std::string group = "/out/" + name;
    // A shape that contradicts the number of values is written flat; /shape still says it.
    const auto length = static_cast<std::int64_t>(array.values.size());
    const bool whole = hdf5_file::count(array.shape) == length;
    hdf5_file::write<double>(part, group + "/values",
                             {whole ? array.shape : std::vector{length}, array.values});
    hdf5_file::write<std::int64_t>(part, group + "/shape",
                                   {{static_cast<std::int64_t>(array.shape.size())}, array.shape});
    hdf5_file::set_attribute(part, group + "/values", "unit", slot_.out(name).unit);
  }
  hdf5_file::write<double>(part, "/seconds", {{1}, {seconds}});
  if (std::rename(part.c_str(), out_file_.c_str()) != 0)
    throw std::runtime_error("cannot rename " + part + ": " + std::strerror(errno));
}

void Participant::fail(const std::string& text) {
  if (slot_.mapped() && !command_.empty()) *slot_.seconds() = monotonic_seconds() - began_;
  command_.clear();
  write_line("error " + text);
}

void Participant::note(const std::string& text) { write_line("note " + text); }

void Participant::saved(const std::string& name, double seconds) {
  char number[32];
  std::snprintf(number, sizeof number, "%.9g", seconds);
  write_line("saved " + name + " " + number);
}

std::int64_t Participant::window(int i) const {
  if (i < 0 || i > 1) throw std::logic_error("sandglassWindow(0) is the index, (1) the iteration");
  if (!in_file_.empty())
    return hdf5_file::read<std::int64_t>(in_file_, "/window")
        .values.at(static_cast<std::size_t>(i));
  if (!slot_.mapped()) throw std::logic_error("the window is known within 'advance' only");
  return slot_.window()[i];
}

double Participant::time(int i) const {
  if (i < 0 || i > 1) throw std::logic_error("sandglassTime(0) is the begin, (1) the end");
  if (!in_file_.empty())
    return hdf5_file::read<double>(in_file_, "/time").values.at(static_cast<std::size_t>(i));
  if (!slot_.mapped()) throw std::logic_error("the time is known within 'advance' only");
  return slot_.time()[i];
}

bool Participant::read_line(std::string& line) {
  for (;;) {
    const std::size_t end = buffer_.find('\n');
    if (end != std::string::npos) {
      line = buffer_.substr(0, end);
      buffer_.erase(0, end + 1);
      return true;
    }
    char chunk[4096];
    const ssize_t got = read(commands_, chunk, sizeof chunk);
    if (got == 0) return false;
    if (got > 0) {
      buffer_.append(chunk, static_cast<std::size_t>(got));
    } else if (errno != EINTR) {
      throw std::runtime_error(std::string("cannot read commands: ") + std::strerror(errno));
    }
  }
}

void Participant::write_line(std::string text) const {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  text += '\n';
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t put = write(replies_, text.data() + done, text.size() - done);
    if (put >= 0) {
      done += static_cast<std::size_t>(put);
    } else if (errno != EINTR) {
      throw std::runtime_error(std::string("cannot write a reply: ") + std::strerror(errno));
    }
  }
}

}  // namespace sandglass
