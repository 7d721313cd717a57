#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hdf5_file.hpp"
#include "slot.hpp"

namespace sandglass {

/// Our end of the participant protocol, version 1 (templates/README.md): commands in by lines, one
/// reply each, fields by way of the slot or of fresh files. Every misuse is a std::logic_error,
/// every failure of the world a std::runtime_error.
class Participant {
 public:
  using Array = hdf5_file::Array<double>;

  /// Reads from `commands` and writes to `replies`, both open file descriptors.
  Participant(int commands, int replies, const std::string& slot);
  /// From SANDGLASS_COMMANDS, SANDGLASS_REPLIES and SANDGLASS_SLOT.
  static std::unique_ptr<Participant> from_environment();

  /// Set up: "ready 1" and the abilities ("memory disk").
  void ready(const std::string& abilities);
  /// Waits for the next command and returns its first word; empty when the orchestrator has gone.
  std::string next();
  /// The field as it was sent, packed.
  [[nodiscard]] Array receive(const std::string& field) const;
  /// Sends an array of any shape. What is more than the slot holds is cut off; the shape tells.
  void send(const std::string& field, const Array& array);
  /// Sends `values` in the shape that fits the field best (see shape_sent).
  void send(const std::string& field, std::vector<double> values);
  /// Replies ok. A field that was not sent in this window is an error.
  void done();
  /// Replies with an error, which ends the run; without a command to answer it is said all the
  /// same.
  void fail(const std::string& text);
  void note(const std::string& text);
  void saved(const std::string& name, double seconds);

  [[nodiscard]] const std::string& path() const { return path_; }  ///< of checkpoint and load
  [[nodiscard]] std::int64_t window(int i) const;                  ///< 0 index, 1 iteration
  [[nodiscard]] double time(int i) const;                          ///< 0 begin, 1 end, in s

 private:
  bool read_line(std::string& line);
  void write_line(std::string text) const;
  void begin_files(const std::string& arguments);
  void write_files(double seconds) const;

  int commands_, replies_;
  Slot slot_;
  std::string buffer_;   ///< read, not yet a whole line
  std::string command_;  ///< the one being answered; empty between two
  std::string path_;
  double began_ = 0;                      ///< when the command was read
  std::string in_file_, out_file_;        ///< of the fresh-file transport; empty: the mapped slot
  std::map<std::string, Array> sent_;     ///< fresh files: what goes into the file at the end
  std::map<std::string, bool> has_sent_;  ///< per field of out
};

/// Seconds on a clock that never jumps.
double monotonic_seconds();

}  // namespace sandglass
