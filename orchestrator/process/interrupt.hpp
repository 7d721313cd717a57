#pragma once

namespace sandglass {

/// Ctrl-C and SIGTERM, turned into something a poll loop can see. Children are in process groups of
/// their own, so the terminal's Ctrl-C reaches only us and we end them in order.
class Interrupt {
 public:
  /// Installs the handlers (once per process; later calls do nothing).
  static void install();
  /// A descriptor that becomes readable at the interrupt; -1 before install().
  static int descriptor();
  static bool requested();
  /// Throws Error::interrupted when the user has asked to stop.
  static void check();
};

}  // namespace sandglass
