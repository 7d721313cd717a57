#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <span>
#include <thread>

#include "base/clock.hpp"
#include "base/file.hpp"
#include "bench/bench.hpp"
#include "bench/loaded.hpp"
#include "process/child.hpp"
#include "record/record.hpp"

namespace sandglass::bench {
namespace {

/// Sends the bytes and takes as many back.
void round_trip(Child& child, const std::string& message, std::string& answer) {
  answer.clear();
  child.write_command(message);
  while (answer.size() < message.size()) {
    pollfd wanted{child.reply_descriptor(), POLLIN, 0};
    ::poll(&wanted, 1, -1);
    if (!child.read_replies(answer)) {
      throw Error::participant("the program at the other end of the pipe has gone", {},
                               end_of_log(child.log()));
    }
  }
}

double record_rate(const std::string& path, std::int64_t values, std::int64_t windows) {
  record::Record record(path, windows,
                        {{"question", "m", "there", "back", {values}, false},
                         {"answer", "m", "back", "there", {values}, false}},
                        {});
  const std::vector<double> field(static_cast<std::size_t>(values), 1.0);
  record::Row row;
  row.fields = {{field, values}, {field, values}};
  const SystemClock clock;
  const double start = clock.now();
  for (std::int64_t window = 0; window < windows; ++window) record.append(row);
  // In the file is enough, as for any program that writes; flush() would wait for the disk itself.
  while (record.windows() < windows) std::this_thread::sleep_for(std::chrono::microseconds(100));
  const double seconds = clock.now() - start;
  record.close();
  std::filesystem::remove(path);
  return 2.0 * static_cast<double>(values * windows) * sizeof(double) / seconds;
}

double plain_rate(const std::string& path, std::int64_t values, std::int64_t windows) {
  const std::vector<char> row(2 * static_cast<std::size_t>(values) * sizeof(double), 'x');
  const SystemClock clock;
  const double start = clock.now();
  std::ofstream file(path, std::ios::binary);
  for (std::int64_t window = 0; window < windows; ++window) {
    file.write(row.data(), static_cast<std::streamsize>(row.size()));
  }
  file.flush();
  if (!file) throw_system_error("write", path, errno);
  const double seconds = clock.now() - start;
  std::filesystem::remove(path);
  return static_cast<double>(row.size()) * static_cast<double>(windows) / seconds;
}

}  // namespace

Spread spread_of(std::vector<double> seconds) {
  if (seconds.empty()) return {};
  std::sort(seconds.begin(), seconds.end());
  const auto at = [&](double share) {
    return seconds[static_cast<std::size_t>(share * static_cast<double>(seconds.size() - 1))];
  };
  return {at(0.5), at(0.1), at(0.9), seconds.size()};
}

OneProcessor::OneProcessor() {
  cpu_set_t here;
  CPU_ZERO(&here);
  CPU_SET(static_cast<std::size_t>(std::max(::sched_getcpu(), 0)), &here);
  held_ = ::sched_getaffinity(0, sizeof before_, &before_) == 0 &&
          ::sched_setaffinity(0, sizeof here, &here) == 0;
}

OneProcessor::~OneProcessor() {
  if (held_) ::sched_setaffinity(0, sizeof before_, &before_);
}

Spread pair_window(const run::Home& home, const std::string& folder, const PairOptions& options) {
  workflow::Workflow pair = loaded(home, home.templates() + "/bench/pair.yaml", {});
  workflow::Coupling& coupling = *pair.coupling;
  const std::int64_t warm_up = options.windows / 10 + 20;
  coupling.windows = options.windows + warm_up;
  coupling.stability.active = options.watched;
  for (workflow::Field& field : coupling.fields) {
    field.shape = field.received_shape = {options.values};
    field.recorded = options.recorded;
  }
  const std::vector<double> ends = window_ends(home, pair, folder).ends;
  return spread_of(differences(std::span(ends).subspan(static_cast<std::size_t>(warm_up))));
}

Spread pipe_window(const run::Home& home, const std::string& folder, std::int64_t values,
                   std::int64_t windows) {
  Command command;
  command.arguments = {"/usr/bin/python3", home.templates() + "/bench/pipe.py",
                       std::to_string(values)};
  command.log = folder + "/pipe.log";
  Child child("pipe", command, true);
  const std::string message(static_cast<std::size_t>(values) * sizeof(double), 'x');
  std::string answer;
  const SystemClock clock;
  std::vector<double> seconds;
  const std::int64_t warm_up = windows / 10 + 20;
  for (std::int64_t window = 0; window < windows + warm_up; ++window) {
    const double start = clock.now();
    round_trip(child, message, answer);
    round_trip(child, message, answer);
    if (window >= warm_up) seconds.push_back(clock.now() - start);
  }
  return spread_of(std::move(seconds));
}

WriteRates write_rates(const std::string& folder, std::int64_t values, std::int64_t windows) {
  WriteRates best;
  for (int turn = 0; turn < 3; ++turn) {
    best.plain = std::max(best.plain, plain_rate(folder + "/plain", values, windows));
    best.record = std::max(best.record, record_rate(folder + "/rate.h5", values, windows));
  }
  return best;
}

}  // namespace sandglass::bench
