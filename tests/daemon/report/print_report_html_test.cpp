#include "daemon/report/print_report_html.hpp"

#include "core/image/thumbnail.hpp"
#include "daemon/report/layer_pictures.hpp"
#include "daemon/report/print_report_json.hpp"
#include "hw/png_file.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/print/rise_fixture.hpp"
#include "tests/daemon/report/print_state.hpp"
#include "tests/daemon/report/report_fixture.hpp"

namespace {

// The limit that docs/printing.md promises.
constexpr std::size_t kLargestPage = 3'000'000;

PrintReport report_of(std::int32_t layers) {
  PrintReport report;
  report.job = "part";
  report.outcome = PrintOutcome::Done;
  report.summary.models.resize(1);
  report.summary.models.front().centers = {{0, 0}};
  report.summary.layers = {layers, Nanometers{50'000}, Nanometers{50'000}, std::nullopt};
  report.summary.irradiance_mw_cm2 = 5;
  const TimePoint start{1h};
  report.states = StateTimes(start);
  for (std::int32_t i = 0; i < layers; ++i) {
    LayerRecord& layer = report.layers.emplace_back();
    layer.layer = i;
    layer.thickness = Nanometers{50'000};
    layer.mask_height = Nanometers{std::int64_t{50'000} * i + 25'000};
    layer.exposure_asked = layer.exposure_least = layer.exposure_most = 2s;
    layer.complete = true;
    layer.area_mm2 = i % 97;
    report.states.enter(i % 2 == 0 ? print_state("exposing") : print_state("lifting"), start + i * 5s);
  }
  return report;
}

LayerPicture picture_of(std::int32_t layer, const Mask& mask) {
  return {layer, "", mask.width(), mask.height(), encode_png(mask), {}, {}};
}

// Returns random pixels, which PNG cannot compress: the largest possible picture.
Mask noise(Pixels side) {
  Mask mask(side, side);
  std::uint32_t state = 1;
  for (std::int32_t y = 0; y < side.count(); ++y) {
    for (std::uint8_t& pixel : mask.row(y))
      pixel = static_cast<std::uint8_t>((state = state * 1664525U + 1013904223U) >> 24U);
  }
  return mask;
}

}  // namespace

TEST_CASE("The page shows the start in local time, as contourctl history does") {
  ::setenv("TZ", "CET-1", 1);
  ::tzset();
  PrintReport report = report_of(1);
  report.started = std::chrono::system_clock::time_point{std::chrono::seconds{1'750'000'000}};
  const std::string page = report_as_html(report);
  ::setenv("TZ", "UTC", 1);
  ::tzset();
  CHECK(page.find("2025-06-15 16:06:40 +0100") != std::string::npos);
  CHECK(page.find("15:06:40") == std::string::npos);
}

TEST_CASE("A warning links only to its layers that have a picture") {
  PrintReport report = report_of(30);
  PrintFindings& findings = report.findings.emplace();
  findings.area_mm2.assign(30, 1);
  findings.islands = {{4, {1, 2}, {0, 0}, 3}, {9, {1, 2}, {0, 0}, 2}};
  findings.island_count = 2;
  report.layer_pictures.push_back(picture_of(9, Mask(Pixels{20}, Pixels{10})));
  const std::string page = report_as_html(report);
  CHECK(testing::occurrences(page, "<a href=\"#layer-10\">layer 10</a>") == 1);
  CHECK(testing::occurrences(page, "<a href=") == 1);
  CHECK(testing::occurrences(page, "<figure id=\"layer-10\">") == 1);
  CHECK(testing::occurrences(page, "2 islands begin") == 1);
}

TEST_CASE("The page and the figures count the layers in which undersides were not found in time") {
  PrintReport report = report_of(30);
  CHECK(report_as_html(report).find("Undersides") == std::string::npos);
  CHECK(report_as_json(report).find("\"unfound_undersides\": 0,") != std::string::npos);
  report.layers[7].undersides_found = report.layers[9].undersides_found = false;
  CHECK(report_as_html(report).find("kept all their light in 2 layers: they were not found within "
                                    "mask_budget_ms") != std::string::npos);
  CHECK(report_as_json(report).find("\"unfound_undersides\": 2,") != std::string::npos);
}

TEST_CASE("The page and the figures count the masks that a rise has shown and missed") {
  PrintReport report = report_of(3);
  CHECK(report_as_html(report).find("missed") == std::string::npos);
  CHECK(report_as_json(report).find("\"frames\": null") != std::string::npos);
  report.layers[1].rises = report.layers[2].rises = true;
  report.layers[1].frames = {40, 2, Nanometers{3'750}, 3ms};
  report.layers[2].frames = {41, 0, Nanometers{1'250}, 5ms};
  CHECK(report_as_html(report).find("81 masks shown, 2 missed, up to 3.75 um") != std::string::npos);
  CHECK(report_as_html(report).find("slowed down") == std::string::npos);
  report.layers[1].frames.slowed = 1;
  CHECK(report_as_html(report).find("slowed down 1 time") != std::string::npos);
  CHECK(testing::lacking(report_as_json(report), {"\"shown\": 81", "\"missed\": 2", "\"farthest_um\": 3.75",
                                                  "\"longest_cut_ms\": 5.0"})
            .empty());
}

TEST_CASE("The page and the figures of a continuous print compare its plan with the time that it took") {
  PrintReport report = report_of(3);
  CHECK(report_as_html(report).find("Rises") == std::string::npos);
  CHECK(report_as_json(report).find("\"continuous\": null") != std::string::npos);
  ContinuousForecast& plan = report.summary.continuous.emplace();
  plan.bounds = rise_bounds(testing::window_resin(), testing::kWindowPrinter);
  report.layers[1].bottom = report.layers[0].thickness;
  const Nanometers top = report.layers[1].bottom + report.layers[1].thickness;
  const MillimetersPerSecond speed{0.01};
  plan.ranges = {{.bottom = {}, .top = report.layers[0].thickness, .time = 100s, .rest = 60s},
                 {.bottom = report.layers[0].thickness,
                  .top = top,
                  .limit = RiseLimit::Cure,
                  .slowest = speed,
                  .fastest = speed,
                  .time = 30s}};
  for (std::size_t i = 0; i < report.layers.size(); ++i) {
    report.layers[i].complete = true;
    report.layers[i].done_after = 110s * (static_cast<int>(i) + 1);
  }
  CHECK(testing::lacking(
            report_as_html(report),
            {"<h2>Rises</h2>", "36</td><td>6.14</td><td>56.7</td><td>272</td><td>30.0 s</td><td>50.0 s</td>",
             "<td>1 min 00 s</td></tr>"}) == "");
  CHECK(testing::lacking(report_as_json(report), {"\"took_s\": 50.0", "\"rest_s\": 60.0"}) == "");
}

TEST_CASE("Hostile names appear on the page only as text") {
  const std::string hostile = "\"><script>alert(1)</script><img src=//x onerror='y'>\x1b[31m\xff";
  PrintReport report = report_of(3);
  report.job = report.printer = report.reason = hostile;
  report.summary.resin.name = hostile;
  report.summary.warnings = {hostile};
  report.summary.models.front().file = hostile;
  report.stops.interruptions = {{1, 1s, hostile}};
  report.busiest_lit = {hostile, 1s, 1s};
  report.layer_pictures.push_back(picture_of(1, Mask(Pixels{20}, Pixels{10})));
  report.layer_pictures.back().why = hostile;
  const std::string page = report_as_html(report);
  CHECK(testing::occurrences(page, "<script") == 0);
  CHECK(testing::occurrences(page, "<img src=//") == 0);
  CHECK(testing::occurrences(page, "\x1b") == 0);
  CHECK(testing::occurrences(page, "\xff") == 0);
  CHECK(testing::occurrences(page, "&lt;script&gt;alert(1)") >= 8);
}

TEST_CASE("A page allows no request and no script") {
  const std::string page = report_as_html(report_of(3));
  CHECK(testing::occurrences(page,
                             "content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'") == 1);
}

TEST_CASE("The page of a print with everything that can go wrong stays below the documented size") {
  PrintReport report = report_of(100'000);
  report.reason = std::string(1'000'000, '<');
  report.summary.warnings.assign(5000, std::string(5000, '<'));
  report.summary.models.resize(5000, report.summary.models.front());
  for (ModelSummary& model : report.summary.models)
    model.file = std::string(255, '<');
  report.stops.interruptions.assign(PrintStops::kMost, {7, 1s, std::string(5000, '<')});
  report.stops.pauses.assign(PrintStops::kMost, {7, 1s, 1s});
  report.stops.more_pauses = 4000;
  report.preview =
      JobPicture{Pixels{720}, encode_png(noise(Pixels{720})),
                 std::vector<JobPicture::Contact>(kMostContacts, {{719.99, 719.99}, ContactCause::Overhang})};
  for (std::size_t i = 0; i < kMaxLayerPictures; ++i)
    report.layer_pictures.push_back(picture_of(static_cast<std::int32_t>(i), noise(kLayerPictureSide)));
  const std::string page = report_as_html(report);
  CHECK(page.size() < kLargestPage);
  CHECK(page.size() > kLargestPage / 2);
  // Warnings, and pauses including those that were not kept.
  CHECK(testing::occurrences(page, "<li>and 4950 more</li>") == 2);
  // Interruptions.
  CHECK(testing::occurrences(page, "<li>and 950 more</li>") == 1);
}

TEST_CASE("The picture of a part shows the contacts of its supports with their causes") {
  PrintReport report = report_of(3);
  report.preview = JobPicture{Pixels{720}, encode_png(noise(Pixels{720})), {}};
  CHECK(testing::occurrences(report_as_html(report), "class=\"contacts\"") == 0);
  report.preview->contacts = {{{100.26, 200}, ContactCause::Island},
                              {{300, 400}, ContactCause::Peel},
                              {{300, 410}, ContactCause::Peel}};
  const std::string page = report_as_html(report);
  CHECK(testing::occurrences(page, "<circle class=\"island\" cx=\"100.3\" cy=\"200.0\"") == 1);
  CHECK(testing::occurrences(page, "<circle class=\"peel\"") == 2);
  CHECK(testing::occurrences(page, "</span>island 1</span>") == 1);
  CHECK(testing::occurrences(page, "</span>peel 2</span>") == 1);
  CHECK(testing::occurrences(page, "</span>overhang") == 0);
}

TEST_CASE("A print that ended before its first layer has a page without pictures and plots") {
  PrintReport report = report_of(0);
  report.outcome = PrintOutcome::Canceled;
  const std::string page = report_as_html(report);
  CHECK(testing::occurrences(page, "<figure") == 0);
  CHECK(testing::occurrences(page, "<svg") == 0);
  CHECK(testing::occurrences(page, "<h2>") == 0);
  CHECK(testing::occurrences(page, "nan") == 0);
}
