// Tests of the errors if there is no chip. Real lines are tested in the virtual machine (tests/vm).
#include "hw/gpio/gpio_lines.hpp"

#include <fstream>

#include "hw/gpio/gpio_axis_config.hpp"
#include "tests/catch.hpp"
#include "tests/hw/refusal.hpp"
#include "tests/temporary_folder.hpp"

namespace {

std::string refusal_of_line(const GpioLineConfig& config, const std::filesystem::path& devices) {
  return testing::refusal_of([&] { return report_line(config, devices); });
}

}  // namespace

TEST_CASE("The error for a missing chip names it and the folder that was searched") {
  const TemporaryFolder devices;
  const std::string none = "there is no GPIO chip below " + devices.path().string();
  const std::string expected = "there is no GPIO chip \"gpiochip9\" by device name, path or label; " + none;
  CHECK(refusal_of_line({"gpiochip9", "17", false}, devices.path()) == expected);
  CHECK(refusal_of_line({"", "17", false}, devices.path()) ==
        "there is no GPIO chip \"\" by device name, path or label; " + none);
}

TEST_CASE("A file that is not a GPIO chip is refused with its path") {
  const TemporaryFolder devices;
  const auto path = devices.path() / "gpiochip0";
  std::ofstream(path) << "not a chip";
  CHECK(refusal_of_line({"gpiochip0", "17", false}, devices.path()) == path.string() + " is not a GPIO chip");
  CHECK(refusal_of_line({path.string(), "17", false}, devices.path()) ==
        path.string() + " is not a GPIO chip");
}

TEST_CASE("The existing chips are listed if none has the wanted label") {
  const TemporaryFolder devices;
  std::ofstream(devices.path() / "gpiochip0") << "not a chip";
  const std::string words = refusal_of_line({"pinctrl-bcm2711", "17", false}, devices.path());
  CHECK(words.starts_with("there is no GPIO chip \"pinctrl-bcm2711\" by device name, path or label; "));
  CHECK(words.find("existing chips: gpiochip0 (") != std::string::npos);
}

TEST_CASE("A line's report is described in one clause") {
  CHECK(describe(GpioLineReport{"gpiochip0", "pinctrl-bcm2711", 17, "GPIO17", std::nullopt, false}) ==
        "line 17 (GPIO17) of gpiochip0 (pinctrl-bcm2711), an input, free");
  CHECK(describe(GpioLineReport{"gpiochip0", "zplant", 22, "", "contourd enable", true}) ==
        "line 22 of gpiochip0 (zplant), an output, used by \"contourd enable\"");
  CHECK(describe(GpioLineReport{"gpiochip0", "zplant", 22, "", "", true}) ==
        "line 22 of gpiochip0 (zplant), an output, used by a program that gives no name");
}

TEST_CASE("A normally closed contact's line is inverted: active means not at rest") {
  for (const bool active_low : {false, true}) {
    GpioInputConfig input{{"gpiochip0", "5", active_low}};
    CHECK(input.logical_line().active_low == active_low);
    input.contact = Contact::NormallyClosed;
    CHECK(input.logical_line().active_low != active_low);
    CHECK(input.logical_line().line == "5");
  }
}
