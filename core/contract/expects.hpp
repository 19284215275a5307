// Preconditions, as the comments of functions state them, checked at the beginning of the function's body. A
// caller that breaks one has a bug that no code can recover from: the program's handler puts the hardware
// into a safe state, and the process is aborted. Any thread, including real-time threads: checking a
// precondition that holds is one comparison, which neither allocates, locks nor throws.
#pragma once

namespace contourd {

struct BrokenContract {
  const char* requirement;  // the condition that does not hold: "the row is in the mask"
  const char* path;         // path of the source file
  int line;

  // Returns the source file's name without its folders.
  [[nodiscard]] const char* file() const noexcept;
};

// A handler for broken contracts. Called on the thread that broke one, on several threads at once if several
// do. Neither allocates nor throws.
using ContractHandler = void (*)(const BrokenContract& broken) noexcept;
// Sets the handler; with nullptr, as by default, the sentence is printed to stderr. Any thread.
void on_broken_contract(ContractHandler handler) noexcept;

// Calls the handler, then aborts.
[[noreturn]] void end_by_contract(const BrokenContract& broken) noexcept;

// Checks a precondition in every build. Path and line are the caller's (like std::source_location's, which
// clang 14 does not have).
[[gnu::always_inline]] constexpr void expects(bool kept, const char* requirement,
                                              const char* path = __builtin_FILE(),
                                              int line = __builtin_LINE()) {
  if (!kept) [[unlikely]]
    end_by_contract({requirement, path, line});
}

// CMakeLists.txt defines CONTOURD_COSTLY_CHECKS for debug, sanitizer and fuzzing builds.
#ifdef CONTOURD_COSTLY_CHECKS
inline constexpr bool kCostlyChecks = true;
#else
inline constexpr bool kCostlyChecks = false;
#endif

// Checks a precondition that takes a loop, or that is checked for every pixel or facet. `kept()` is called
// only in builds with costly checks.
template <typename Condition>
[[gnu::always_inline]] constexpr void expects_costly(Condition kept, const char* requirement,
                                                     const char* path = __builtin_FILE(),
                                                     int line = __builtin_LINE()) {
  if constexpr (kCostlyChecks) expects(kept(), requirement, path, line);
}

}  // namespace contourd
