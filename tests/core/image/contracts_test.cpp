// That RunDeflater checks what it requires.
#include "core/image/run_deflater.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

using namespace contourd;
using testing::contract_broken_by;

TEST_CASE("A stream of runs is at most as long as the largest mask's") {
  if (testing::costly_checks_are_off()) return;
  const auto stream_of = [](std::size_t bytes) {
    return contract_broken_by([bytes] {
      std::vector<std::uint8_t> out;
      RunDeflater deflater;
      deflater.begin(out, 0);
      deflater.add(255, 1);
      deflater.add(255, bytes - 1);
    });
  };
  CHECK(stream_of(RunDeflater::kMaxBytes).empty());
  CHECK(stream_of(RunDeflater::kMaxBytes + 1) == "a stream has at most kMaxBytes");
}
