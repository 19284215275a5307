#include "daemon/ctl/calibration/fit_plot.hpp"

#include <regex>
#include <string>
#include <vector>

#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

namespace contourd::ctl {
namespace {

std::size_t count_in(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
    ++count;
  return count;
}

// Returns the numbers of the first attribute of that name, pairs of coordinates.
std::vector<double> numbers_in(const std::string& svg, const std::string& element) {
  const std::size_t from = svg.find("points=\"", svg.find(element)) + 8;
  const std::string text = svg.substr(from, svg.find('"', from) - from);
  std::vector<double> numbers;
  const std::regex number("-?[0-9.]+");
  for (std::sregex_iterator each(text.begin(), text.end(), number), end; each != end; ++each)
    numbers.push_back(std::stod(each->str()));
  return numbers;
}

TEST_CASE(
    "A plot has a dot for each measurement, the line, and a band of two standard deviations around it") {
  const PlottedFit fit{.measured = {{1, 10}, {2, 21}, {3, 29}}, .line = {{1, 10, 1}, {3, 30, 2}}};
  const std::string svg = svg_of_fit({"x", "y", Scale::Linear, {fit}});
  CHECK(count_in(svg, "<circle") == 3);
  CHECK(svg.find("<title>2: 21</title>") != std::string::npos);
  const std::vector<double> line = numbers_in(svg, "<polyline"), band = numbers_in(svg, "<polygon");
  REQUIRE(line.size() == 4);
  REQUIRE(band.size() == 8);
  // Upper side from left to right, lower side back: at its ends, the band is 4 and 8 units high, 20 are
  // 'step'.
  const double step = (line[1] - line[3]) / 20;
  CHECK(step > 0);  // upwards is a smaller y
  CHECK(band[1] == Approx(line[1] - 2 * step).margin(0.11));
  CHECK(band[3] == Approx(line[3] - 4 * step).margin(0.11));
  CHECK(band[5] == Approx(line[3] + 4 * step).margin(0.11));
  CHECK(band[7] == Approx(line[1] + 2 * step).margin(0.11));
}

TEST_CASE(
    "On a logarithmic scale, equal factors are equally far apart, and ticks are 1, 2 and 5 of each decade") {
  const PlottedFit fit{.measured = {{10, 1}}, .line = {{10, 1, 0}, {40, 2, 0}, {160, 3, 0}}};
  const std::string svg = svg_of_fit({"dose", "depth", Scale::Logarithmic, {fit}});
  const std::vector<double> line = numbers_in(svg, "<polyline");
  REQUIRE(line.size() == 6);
  CHECK(line[2] - line[0] == Approx(line[4] - line[2]).margin(0.11));
  for (const char* tick : {">10<", ">20<", ">50<", ">100<"})
    CHECK(svg.find(tick) != std::string::npos);
  CHECK(svg.find(">5<") == std::string::npos);
}

TEST_CASE("A plot of one point or of equal values has axes, and names are safe in HTML") {
  for (const PlottedFit& fit :
       {PlottedFit{.measured = {{1, 1}}, .line = {{1, 1, 0}}},
        PlottedFit{.name = "<a&b>", .measured = {{1, 7}, {2, 7}}, .line = {{1, 7, 0}, {2, 7, 0}}}}) {
    const std::string svg = svg_of_fit({"x", "y", Scale::Linear, {fit}});
    CHECK(svg.find("nan") == std::string::npos);
    CHECK(svg.find("inf") == std::string::npos);
    CHECK(svg.find("<a&") == std::string::npos);
    CHECK(count_in(svg, "class=\"grid\"") > 3);
  }
}

TEST_CASE("The map of a lamp shows the readings where they were taken") {
  std::vector<LampReading> readings;
  for (const double y : {-0.8, 0.0, 0.8})
    for (const double x : {-0.8, 0.0, 0.8})
      readings.push_back({{x, y}, 40 - 6 * x * x - 4 * y * y - x});
  const std::string map = map_of_lamp(fit_lamp(readings), readings, 16.0 / 9);
  CHECK(count_in(map, "<circle") == 9);
  CHECK(map.find("viewBox=\"0 0 192 108\"") != std::string::npos);
  CHECK(map.find("cx=\"19.2\" cy=\"10.8\"") != std::string::npos);
  CHECK(map.find("src=\"data:image/png;base64,") != std::string::npos);
}

TEST_CASE("Plots require measurements, positive values on a logarithmic scale, and an aspect") {
  CHECK(contract_broken_by([] {
          (void)svg_of_fit({"x", "y", Scale::Linear, {}});
        }) == "a plot shows a measurement");
  CHECK(contract_broken_by([] {
          (void)svg_of_fit({"x", "y", Scale::Logarithmic, {PlottedFit{.measured = {{0, 1}}}}});
        }) == "a logarithmic scale shows positive values");
  CHECK(contract_broken_by([] { (void)map_of_lamp({}, {}, 0); }) == "a display has an aspect");
}

}  // namespace
}  // namespace contourd::ctl
