// The functions of daemon/check check their preconditions.
#include <unistd.h>

#include "daemon/check/config_check.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

TEST_CASE("Only root can check another user's access") {
  CHECK(contract_broken_by([] {
          if (::geteuid() == 0 && ::seteuid(65534) != 0) return;
          (void)out_of_reach({}, {});
        }) == "this process runs as root");
}
