// How a long stage tells where it is, and learns that it should stop.
#pragma once

#include <functional>
#include <string_view>

#include "common/error.h"

namespace transformables {

/// Called now and then by a long stage, from the thread that called the stage.
struct Progress {
  /// Takes the share of the stage that is done (0 to 1) and a short note; returns false to stop the stage.
  std::function<bool(double fraction, std::string_view note)> tell;

  /// @throws Cancelled when `tell` returned false.
  void operator()(double fraction, std::string_view note = {}) const {
    if (tell && !tell(fraction, note)) throw Cancelled();
  }
};

}  // namespace transformables
