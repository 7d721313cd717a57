#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <list>
#include <memory>

#include "base/clock.hpp"
#include "base/error.hpp"
#include "process/child.hpp"
#include "study/executor.hpp"

namespace sandglass::study {
namespace {

constexpr double kForever = 1e9;  // s: a run has deadlines of its own
constexpr double kPatience = 10;  // s for runs to end in order when the user interrupts
constexpr useconds_t kLook = 20'000;

using Children = std::list<std::unique_ptr<Child>>;

/// Runs that are asked to end write down how far they came; those that do not listen within
/// kPatience are killed by their destructors.
void end_in_order(Children& children) {
  for (const auto& child : children) ::kill(child->process_id(), SIGTERM);
  const SystemClock clock;
  const double end = clock.now() + kPatience;
  while (clock.now() < end) {
    std::erase_if(children, [](const auto& child) { return child->poll_exit().has_value(); });
    if (children.empty()) return;
    ::usleep(kLook);
  }
}

}  // namespace

void run_locally(const std::vector<Task>& tasks, int jobs, const Listener& listener) {
  Children running;
  Watch watch;
  auto next = tasks.begin();
  try {
    while (next != tasks.end() || !running.empty()) {
      while (next != tasks.end() && running.size() < static_cast<std::size_t>(std::max(1, jobs))) {
        Command command;
        command.arguments = next->arguments;
        command.log = next->log;
        running.push_back(std::make_unique<Child>(next->point, command, false));
        watch.add(running.back().get());
        listener.started(next->point);
        ++next;
      }
      Child* ended = watch.wait(-1, kForever).child;
      if (ended == nullptr) continue;
      static_cast<void>(ended->poll_exit());
      watch.remove(ended);
      const std::string point = ended->name();
      running.remove_if([&](const auto& child) { return child.get() == ended; });
      listener.ended(point);
    }
  } catch (...) {
    end_in_order(running);
    throw;
  }
}

}  // namespace sandglass::study
