#include "daemon/web/mqtt/mqtt_settings.hpp"

#include <stdexcept>

#include "tests/catch.hpp"
#include "tests/message_of.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using namespace contourd::testing;
using namespace contourd::web;

TEST_CASE("the settings of a broker are read as they were written") {
  const TemporaryFolder folder;
  const MqttSettings settings{.host = "fd00::1",
                              .port = 8883,
                              .user = "printer",
                              .password = " a b\xc3\xa4 ",
                              .ca_file = "/etc/ssl/my ca.pem",
                              .prefix = "ha/test"};
  write_mqtt(folder.path() / "web-mqtt", settings);
  CHECK(read_mqtt(folder.path() / "web-mqtt") == settings);
  CHECK_FALSE(read_mqtt(folder.path() / "none"));
}

TEST_CASE("a password without a user, a long one and one with a line break are refused") {
  MqttSettings settings{.host = "host", .port = 1883};
  check_mqtt(settings);
  settings.password = "secret";
  CHECK_THROWS_AS(check_mqtt(settings), std::runtime_error);
  settings.user = "printer";
  check_mqtt(settings);
  settings.password = std::string(257, 'x');
  CHECK(message_of<std::runtime_error>([&] { check_mqtt(settings); }).find("256") != std::string::npos);
  settings.password = "a\nuser b";
  CHECK_THROWS_AS(check_mqtt(settings), std::runtime_error);
}
