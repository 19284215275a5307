#include "core/contract/expects.hpp"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace contourd {
namespace {

void tell(const BrokenContract& broken) noexcept {
  std::fprintf(stderr, "broken contract in %s, line %d: %s\n", broken.file(), broken.line,
               broken.requirement);
}

constinit std::atomic<ContractHandler> broken_contract_handler{tell};
// What the handler calls may break one, too.
constinit thread_local bool ending = false;

}  // namespace

const char* BrokenContract::file() const noexcept {
  const char* const slash = std::strrchr(path, '/');
  return slash != nullptr ? slash + 1 : path;
}

void on_broken_contract(ContractHandler handler) noexcept {
  broken_contract_handler = handler != nullptr ? handler : tell;
}

void end_by_contract(const BrokenContract& broken) noexcept {
  if (!ending) {
    ending = true;
    broken_contract_handler.load()(broken);
  }
  std::abort();
}

}  // namespace contourd
