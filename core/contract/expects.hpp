// What a function requires of its caller, as its comment says, checked where its body begins. Who breaks a
// contract has made a mistake that nobody can go on from: the program's handler makes safe what it drives,
// and the process is aborted. Any thread, real-time ones too: a contract that is kept is a comparison, which
// neither allocates, locks nor throws.
#pragma once

namespace contourd {

struct BrokenContract {
  const char* requirement;  // what was to be so: "the row is one of the mask's"
  const char* path;         // of the source
  int line;

  // The source's name, without its folders.
  [[nodiscard]] const char* file() const noexcept;
};

// Runs on the thread that broke a contract, on several at once if several do. Neither allocates nor throws.
using ContractHandler = void (*)(const BrokenContract& broken) noexcept;
// Without one, the sentence goes to stderr. Any thread.
void on_broken_contract(ContractHandler handler) noexcept;

// Calls the handler, then aborts.
[[noreturn]] void end_by_contract(const BrokenContract& broken) noexcept;

// In every build. Path and line are the caller's (as std::source_location's, which clang 14 does not have).
[[gnu::always_inline]] constexpr void expects(bool kept, const char* requirement,
                                              const char* path = __builtin_FILE(),
                                              int line = __builtin_LINE()) {
  if (!kept) [[unlikely]]
    end_by_contract({requirement, path, line});
}

// The build says so: debug, sanitizers, fuzzing (see CMakeLists.txt).
#ifdef CONTOURD_COSTLY_CHECKS
inline constexpr bool kCostlyChecks = true;
#else
inline constexpr bool kCostlyChecks = false;
#endif

// What takes a loop, or stands in one that runs for every pixel or facet: `kept()` is called only there.
template <typename Condition>
[[gnu::always_inline]] constexpr void expects_costly(Condition kept, const char* requirement,
                                                     const char* path = __builtin_FILE(),
                                                     int line = __builtin_LINE()) {
  if constexpr (kCostlyChecks) expects(kept(), requirement, path, line);
}

}  // namespace contourd
