// Claims that must hold whatever a user does.
#pragma once

#include <fmt/format.h>

#include <stdexcept>

namespace lacquer {

/// A broken invariant: a bug of ours, not of the scene.
class CheckError : public std::logic_error {
  public:
    using std::logic_error::logic_error;
};

[[noreturn]] inline void CheckFailed(const char* claim, const char* file, int line) {
    throw CheckError(fmt::format("{}:{}: broken invariant: {}", file, line, claim));
}

}  // namespace lacquer

#define LACQUER_CHECK(claim)                                              \
    do {                                                                  \
        if (!(claim)) ::lacquer::CheckFailed(#claim, __FILE__, __LINE__); \
    } while (false)
#ifdef NDEBUG
#define LACQUER_DCHECK(claim) \
    do {                      \
    } while (false)
#else
#define LACQUER_DCHECK(claim) LACQUER_CHECK(claim)
#endif
