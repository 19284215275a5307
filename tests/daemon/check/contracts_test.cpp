// Each header of daemon/check checks what it requires.
#include <unistd.h>

#include "daemon/check/service_user.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

using namespace contourd;
using testing::contract_broken_by;

TEST_CASE("Only root looks what another user can reach") {
  CHECK(contract_broken_by([] {
          if (::geteuid() == 0 && ::seteuid(65534) != 0) return;
          (void)out_of_reach({}, {});
        }) == "this process is root's");
}
