// Real lines are tested in the virtual machine (tests/vm); here, what is said where there is no chip.
#include "hw/gpio/gpio_lines.hpp"

#include <fstream>

#include "hw/gpio/gpio_axis_config.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using testing::TemporaryFolder;

namespace {

std::string refusal(const GpioLineConfig& config, const std::filesystem::path& devices) {
  try {
    (void)report_line(config, devices);
  } catch (const HardwareError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("A chip that is not there is named together with where chips were looked for") {
  const TemporaryFolder devices;
  const std::string none = "there is no GPIO chip below " + devices.path().string();
  const std::string expected = "there is no GPIO chip \"gpiochip9\" by device name, path or label; " + none;
  CHECK(refusal({"gpiochip9", "17", false}, devices.path()) == expected);
  CHECK(refusal({"", "17", false}, devices.path()) ==
        "there is no GPIO chip \"\" by device name, path or label; " + none);
}

TEST_CASE("A file that is no GPIO chip is refused by name") {
  const TemporaryFolder devices;
  const auto path = devices.path() / "gpiochip0";
  std::ofstream(path) << "not a chip";
  CHECK(refusal({"gpiochip0", "17", false}, devices.path()) == path.string() + " is no GPIO chip");
  CHECK(refusal({path.string(), "17", false}, devices.path()) == path.string() + " is no GPIO chip");
}

TEST_CASE("The chips that are there are listed when a label fits none") {
  const TemporaryFolder devices;
  std::ofstream(devices.path() / "gpiochip0") << "not a chip";
  const std::string words = refusal({"pinctrl-bcm2711", "17", false}, devices.path());
  CHECK(words.starts_with("there is no GPIO chip \"pinctrl-bcm2711\" by device name, path or label; "));
  CHECK(words.find("there are gpiochip0 (") != std::string::npos);
}

TEST_CASE("A line's report reads as a sentence's part") {
  CHECK(describe(GpioLineReport{"gpiochip0", "pinctrl-bcm2711", 17, "GPIO17", std::nullopt, false}) ==
        "line 17 (GPIO17) of gpiochip0 (pinctrl-bcm2711), an input, free");
  CHECK(describe(GpioLineReport{"gpiochip0", "zplant", 22, "", "contourd enable", true}) ==
        "line 22 of gpiochip0 (zplant), an output, used by \"contourd enable\"");
  CHECK(describe(GpioLineReport{"gpiochip0", "zplant", 22, "", "", true}) ==
        "line 22 of gpiochip0 (zplant), an output, used by something that does not say its name");
}

TEST_CASE("A normally closed contact's line is taken the other way round: active is not at rest") {
  for (const bool active_low : {false, true}) {
    GpioInputConfig input{{"gpiochip0", "5", active_low}};
    CHECK(input.logical_line().active_low == active_low);
    input.contact = Contact::NormallyClosed;
    CHECK(input.logical_line().active_low != active_low);
    CHECK(input.logical_line().line == "5");
  }
}
