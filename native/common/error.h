// The three ways in which a job can end without a result. Anything else that is thrown is a bug.
#pragma once

#include <stdexcept>
#include <string>

namespace transformables {

/// The user's data or option can't be used; the text says which one, what is wrong and what to do.
class InvalidInput : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The data is sound, but no design exists under these demands; the text says which demand.
class Infeasible : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The user asked for a stop.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("cancelled") {}
};

}  // namespace transformables
