#include "core/contract/expects.hpp"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace contourd {
namespace {

void print_to_stderr(const BrokenContract& broken) noexcept {
  std::fprintf(stderr, "broken contract in %s, line %d: %s\n", broken.file(), broken.line,
               broken.requirement);
}

constinit std::atomic<ContractHandler> broken_contract_handler{print_to_stderr};
// True while this thread runs the handler: a function that the handler calls may break a contract too.
constinit thread_local bool ending = false;

}  // namespace

const char* BrokenContract::file() const noexcept {
  const char* const slash = std::strrchr(path, '/');
  return slash != nullptr ? slash + 1 : path;
}

void on_broken_contract(ContractHandler handler) noexcept {
  broken_contract_handler = handler != nullptr ? handler : print_to_stderr;
}

void end_by_contract(const BrokenContract& broken) noexcept {
  if (!ending) {
    ending = true;
    broken_contract_handler.load()(broken);
  }
  std::abort();
}

}  // namespace contourd
