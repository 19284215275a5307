#include "core/contract/expects.hpp"

#include <signal.h>

#include <thread>

#include "tests/allocation_counter.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

namespace {

struct End {
  int status = 0;
  std::string said;  // output to stderr
};

// Makes the call in a child process and returns how the child ended.
template <typename Call>
End end_of(Call call) {
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGABRT, SIG_DFL);  // Catch2 would report it as this test's
    ::dup2(ends[1], STDERR_FILENO);
    call();
    ::_exit(0);
  }
  ::close(ends[1]);
  End end;
  end.said = testing::read_all(ends[0]);
  ::close(ends[0]);
  ::waitpid(child, &end.status, 0);
  return end;
}

void halve(int number) {
  expects(number % 2 == 0, "the number is even");
}

constexpr int checked(int number) {
  expects(number > 0, "the number is positive");
  return number;
}
static_assert(checked(1) == 1, "a contract that is kept is a constant expression");

}  // namespace

TEST_CASE("A contract that is kept prints nothing and allocates nothing") {
  const End end = end_of([] { halve(2); });
  CHECK(end.status == 0);
  CHECK(end.said.empty());
  const long before = testing::allocations();
  halve(4);
  CHECK(testing::allocations() == before);
}

TEST_CASE("A broken contract aborts the process and prints its place and requirement") {
  const End end = end_of([] { halve(3); });
  CHECK(WIFSIGNALED(end.status));
  CHECK(WTERMSIG(end.status) == SIGABRT);
  CHECK(end.said.starts_with("broken contract in expects_test.cpp, line "));
  CHECK(end.said.ends_with(": the number is even\n"));
}

TEST_CASE("A broken contract calls the handler, and the process ends even if the handler returns") {
  const End end = end_of([] {
    on_broken_contract([](const BrokenContract& broken) noexcept {
      ::dprintf(STDERR_FILENO, "light off, for %s", broken.requirement);
    });
    halve(1);
    ::dprintf(STDERR_FILENO, ", and on");
  });
  CHECK(end.said == "light off, for the number is even");
  CHECK(WIFSIGNALED(end.status));
}

TEST_CASE("A handler that breaks a contract itself is not called again, and the process ends") {
  const End end = end_of([] {
    on_broken_contract([](const BrokenContract&) noexcept {
      ::dprintf(STDERR_FILENO, "once ");
      halve(5);
    });
    halve(1);
  });
  CHECK(end.said == "once ");
  CHECK(WIFSIGNALED(end.status));
}

TEST_CASE("A contract can be broken in a noexcept function or on another thread") {
  CHECK(contract_broken_by([]() noexcept { halve(1); }) == "the number is even");
  CHECK(contract_broken_by([] { std::thread([] { halve(1); }).join(); }) == "the number is even");
  CHECK(contract_broken_by([] { halve(0); }).empty());
}

TEST_CASE("A costly check is made in builds for finding mistakes, and not evaluated in others") {
  int looks = 0;
  expects_costly([&] { return ++looks > 0; }, "it was looked");
  CHECK(looks == (kCostlyChecks ? 1 : 0));
  const auto break_it = [] { expects_costly([] { return false; }, "never so"); };
  CHECK(contract_broken_by(break_it) == (kCostlyChecks ? "never so" : ""));
}
