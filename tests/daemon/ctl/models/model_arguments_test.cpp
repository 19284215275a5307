#include "daemon/ctl/models/model_arguments.hpp"

#include "daemon/ctl/terminal/exit_codes.hpp"
#include "tests/catch.hpp"

using namespace contourd::ctl;

TEST_CASE("The option --up accepts a direction or a preset") {
  CHECK(parse_up("auto") == UpOption{OrientationPreset::Auto});
  CHECK(parse_up("safe") == UpOption{OrientationPreset::Safe});
  CHECK(parse_up("1,-2.5,1e-3") == UpOption{Direction{1, -2.5, 1e-3}});
}

TEST_CASE("The option --up refuses any other word") {
  for (const char* word :
       {"", "Auto", "1,2", "1,2,3,4", "1,2,3x", "1;2;3", "0,0,0", "nan,0,1", "inf,0,1", "1e999,0,0"})
    CHECK_THROWS_AS(parse_up(word), UsageError);
}
