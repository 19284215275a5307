#include "daemon/formats/sl1_outlines.hpp"

#include <fmt/format.h>

#include "core/contour/filled_area.hpp"
#include "daemon/formats/model_input.hpp"
#include "daemon/formats/svg_layer.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/formats/packed_models.hpp"
#include "tests/message_of.hpp"

namespace {

constexpr std::uint64_t kEnoughMemory = std::uint64_t{1} << 30U;
// 6 x 4 mm.
const DisplayGeometry kOutlinePanel{Pixels{120}, Pixels{80}, Micrometers{50}};
constexpr std::string_view kHeader =
    "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\"?>\n"
    "<!DOCTYPE svg PUBLIC \"-//W3C//DTD SVG 1.0//EN\" "
    "\"http://www.w3.org/TR/2001/REC-SVG-20010904/DTD/svg10.dtd\">\n";

// A flag of 2 x 1 mm whose lower left corner is 0.5 mm right of the plate's middle and 0.25 mm above it.
constexpr std::string_view kFlag = R"(<path d="M 5500 1750 l 0 -1000 -2000 0 0 1000 z" />)";

std::string svg(std::string_view paths,
                std::string_view attributes = R"(height="4mm" width="6mm" viewBox="0 0 6000 4000")") {
  return fmt::format("{}<svg {} style=\"fill: white\" xmlns=\"http://www.w3.org/2000/svg\">{}</svg>", kHeader,
                     attributes, paths);
}

std::string slicer_ini(std::string_view more = "") {
  return fmt::format(
      "display_pixels_x = 120\ndisplay_pixels_y = 80\ndisplay_width = 6\ndisplay_height = 4\n{}", more);
}

std::vector<testing::PackedFile> archive_of(const std::vector<std::string>& layers,
                                            const std::string& slicer = slicer_ini()) {
  std::vector<testing::PackedFile> files{
      {"config.ini", fmt::format("jobDir = part\nlayerHeight = 0.05\nnumFast = {}\n", layers.size())}};
  if (!slicer.empty()) files.push_back({"prusaslicer.ini", slicer});
  for (std::size_t layer = 0; layer < layers.size(); ++layer)
    files.push_back({fmt::format("part{:05}.svg", layer), layers[layer]});
  return files;
}

class OutlineArchive {
 public:
  explicit OutlineArchive(const std::vector<testing::PackedFile>& files)
      : opened_(open_models(folder_.write("any-name", testing::zipped(files)))) {}

  const SlicedArchive& archive() { return *opened_.models.front().input->sliced(); }
  std::shared_ptr<const OutlineStack> read(const DisplayGeometry& display = kOutlinePanel,
                                           std::uint64_t most_bytes = kEnoughMemory) {
    return read_outlines(archive(), display, most_bytes, {});
  }

 private:
  testing::TemporaryFolder folder_;
  OpenedModels opened_;
};

// Returns the rectangle around the flag on the plate, as "low x, low y, high x, high y" in millimetres.
std::string place_of(const std::string& layer, const std::string& slicer,
                     const DisplayGeometry& display = kOutlinePanel) {
  const auto stack = OutlineArchive(archive_of({layer}, slicer)).read(display);
  const auto [low, high] = *stack->box();
  return fmt::format("{}, {}, {}, {}", low.x, low.y, high.x, high.y);
}

double area_of(std::string_view paths) {
  Contours section;
  OutlineArchive(archive_of({svg(paths)})).read()->section_at(Nanometers{0}, section);
  return filled_area_mm2(section);
}

std::string refusal_of(const std::vector<testing::PackedFile>& files) {
  return testing::message_of<ModelError>([&] { (void)OutlineArchive(files).read(); });
}

std::string refusal_of(std::string_view layer) {
  return refusal_of(archive_of({std::string(layer)}));
}

}  // namespace

TEST_CASE("Outlines stand on the plate at the size and the place that their header names") {
  CHECK(place_of(svg(kFlag), slicer_ini()) == "0.5, 0.25, 2.5, 1.25");
  // A finer grid, with an origin of its own.
  const std::string fine = svg(R"(<path d="M 65000 27500 L 65000 17500 45000 17500 45000 27500 z"/>)",
                               R"(height="4.0mm" width="6.0mm" viewBox="10000 10000 60000 40000")");
  CHECK(place_of(fine, slicer_ini()) == "0.5, 0.25, 2.5, 1.25");
  // The pixels of the sliced display do not matter.
  CHECK(place_of(svg(kFlag), slicer_ini(), {Pixels{60}, Pixels{40}, Micrometers{100}}) ==
        "0.5, 0.25, 2.5, 1.25");
}

TEST_CASE("The slicer's mirrors and its portrait orientation are undone") {
  CHECK(place_of(svg(kFlag), slicer_ini("display_mirror_x = 1")) == "-2.5, 0.25, -0.5, 1.25");
  CHECK(place_of(svg(kFlag), slicer_ini("display_mirror_y = 1")) == "0.5, -1.25, 2.5, -0.25");
  // On end, x of the plate runs upwards in the picture, and y to the left.
  const std::string on_end = svg(R"(<path d="M 1750 2500 l 0 -2000 -1000 0 0 2000 z"/>)",
                                 R"(width="4mm" height="6mm" viewBox="0 0 4000 6000")");
  const std::string portrait = "display_orientation = portrait\n";
  CHECK(place_of(on_end, slicer_ini(portrait)) == "0.5, 0.25, 2.5, 1.25");
  CHECK(place_of(on_end, slicer_ini(portrait + "display_mirror_x = 1")) == "0.5, -1.25, 2.5, -0.25");
  // An upright display gets the upright picture as it is, and a flat one turned.
  const DisplayGeometry upright{Pixels{80}, Pixels{120}, Micrometers{50}};
  CHECK(place_of(on_end, slicer_ini(portrait), upright) == "-1.25, 0.5, -0.25, 2.5");
  CHECK(place_of(svg(kFlag), slicer_ini(), upright) == "-1.25, 0.5, -0.25, 2.5");
}

TEST_CASE("Without prusaslicer.ini, outlines come out on the display as the file has them") {
  DisplayGeometry display = kOutlinePanel;
  CHECK(place_of(svg(kFlag), "", display) == "0.5, 0.25, 2.5, 1.25");
  display.mirror_x = true;
  CHECK(place_of(svg(kFlag), "", display) == "-2.5, 0.25, -0.5, 1.25");
}

TEST_CASE("Rings are united by the non-zero rule, whichever way they run") {
  const std::string_view turned = R"(<path d="M 5500 1750 l -2000 0 0 -1000 2000 0 z" />)";
  CHECK(area_of(kFlag) == Approx(2));
  CHECK(area_of(turned) == Approx(2));
  CHECK(area_of(std::string(kFlag) + std::string(kFlag)) == Approx(2));
  // A hole runs the other way than the ring around it.
  CHECK(
      area_of(
          R"(<path d="M 5500 1750 l 0 -1000 -2000 0 0 1000 z"/><path d="M 5000 1500 l -1000 0 0 -500 1000 0 z"/>)") ==
      Approx(1.5));
  // Two rings that overlap.
  CHECK(area_of(R"(<path d="M 0 0 h 1000 v 1000 H 0 Z M500,500L1500,500,1500,1500,500,1500z"/>)") ==
        Approx(1.75));
  // Groups, signs, exponents, and what PrusaSlicer leaves of a tiny detail.
  CHECK(
      area_of(
          R"(<g><title>x</title><path d="M+1e3-0L2000-0 2e3 1000 1000 1000z"/><path d="M 5 5 l z"/></g>)") ==
      Approx(1));
}

TEST_CASE("Outlines that the display cannot show are refused with a sentence that says why") {
  const auto path = [](std::string_view d) { return svg(fmt::format("<path d=\"{}\"/>", d)); };
  const auto lacks = [](std::string_view layer, std::initializer_list<std::string> words) {
    return testing::lacking(refusal_of(layer), words);
  };
  CHECK(lacks(path("M 0 0 l 10 0 0 10"), {"part00000.svg", "line 3", "not closed"}).empty());
  CHECK(lacks(path("M 0 0 l 10 0 M 5 5 l 5 5 5 0 z"), {"not closed"}).empty());
  CHECK(lacks(path("M 0 0 l NaN 0 0 10 z"), {"command", "N"}).empty());
  CHECK(lacks(path("M 0 0 l -nan 0 0 10 z"), {"-nan"}).empty());
  CHECK(lacks(path("M 0 0 l 1e300 0 0 10 z"), {"1e+300", "beside the viewBox"}).empty());
  CHECK(lacks(path("M 0 0 l 1e999 0 0 10 z"), {"1e999", "number"}).empty());
  CHECK(lacks(path("M 0 0 l 5 z"), {"number"}).empty());
  CHECK(lacks(path("5 5 z"), {"without a command"}).empty());
  CHECK(lacks(path("M 0 0 C 0 0 1 1 2 2 z"), {"command", "C", "straight"}).empty());
  CHECK(lacks(svg("<rect width=\"5\"/>"), {"rect", "outline"}).empty());
  CHECK(lacks(svg("<g transform=\"scale(2)\"/>"), {"g", "transform"}).empty());
  CHECK(lacks(svg("<g fill-rule=\"evenodd\"/>"), {"g", "evenodd", "nonzero"}).empty());
  CHECK(lacks(svg("<path style=\"fill-rule: evenodd\" d=\"\"/>"), {"path", "evenodd"}).empty());
  CHECK(lacks(svg("<path style=\"transform: scale(2)\" d=\"\"/>"), {"path", "moved or hidden"}).empty());
  CHECK(lacks(svg("<g display=\"none\"/>"), {"g", "moved or hidden"}).empty());
  CHECK(lacks(svg("<svg/>"), {"svg", "not expected"}).empty());
  CHECK(area_of("<g style=\"display:inline; fill-rule: nonzero\">" + std::string(kFlag) + "</g>") ==
        Approx(2));
  CHECK(lacks("<html/>", {"html", "not expected"}).empty());
  CHECK(lacks(svg(kFlag, R"(width="6mm" height="4mm")"), {"viewBox", "four numbers"}).empty());
  CHECK(lacks(svg(kFlag, R"(width="6mm" height="4mm" viewBox="0 0 6000 0")"), {"viewBox"}).empty());
  CHECK(lacks(svg(kFlag, R"(width="6mm" height="4mm" viewBox="0 0 inf 1")"), {"viewBox"}).empty());
  for (const std::string_view width : {"6", "6in", "0mm", "-6mm", "nanmm", "1e9mm", ""})
    CHECK(lacks(svg(kFlag, fmt::format(R"(width="{}" height="4mm" viewBox="0 0 6000 4000")", width)),
                {"width", "96mm"})
              .empty());
  CHECK(lacks(svg(kFlag, R"(width="7mm" height="4mm" viewBox="0 0 6000 4000")"),
              {"6.00 x 4.00 mm", "7.00 x 4.00 mm"})
            .empty());
  CHECK(lacks("<svg", {"not valid XML"}).empty());
  CHECK(lacks(R"(<!DOCTYPE svg [<!ENTITY a "b">]><svg/>)", {"document type"}).empty());
  CHECK(lacks(svg("&a;"), {"not valid XML"}).empty());
  CHECK(lacks("<?xml version=\"1.0\"?><!DOCTYPE svg SYSTEM \"a.dtd\"><svg/>", {"standalone"}).empty());
  CHECK(lacks(svg(""), {"none of its layers"}).empty());
}

TEST_CASE("Layers of several kinds or sizes, and layers that are missing, are refused") {
  const std::string layer = svg(kFlag);
  const auto lacks = [](const std::vector<testing::PackedFile>& files,
                        std::initializer_list<std::string> words) {
    return testing::lacking(refusal_of(files), words);
  };
  auto files = archive_of({layer, layer});
  files.push_back({"part00002.png", "x"});
  CHECK(lacks(files, {"two files", "part00001.svg", "part00002.png"}).empty());
  files = archive_of({layer, layer, layer});
  files.erase(files.end() - 2);
  CHECK(lacks(files, {"outline of layer 2, part00001.svg, is missing"}).empty());
  CHECK(lacks(archive_of({layer, svg(kFlag, R"(width="6mm" height="4.01mm" viewBox="0 0 6000 4000")")}),
              {"part00001.svg", "4.01 mm"})
            .empty());
}

TEST_CASE("Outlines are bounded in points and memory, and a stop ends their reading") {
  std::string rings;
  // Each ring has 4 points; all of them are one square.
  for (std::size_t ring = 0; ring <= kMostSvgPoints / 4; ++ring)
    rings += "<path d=\"M0 0h9v9h-9z\"/>";
  CHECK(testing::lacking(refusal_of(svg(rings)), {"1000000 points", "print the model itself"}).empty());
  // A tag of a megabyte is read, with few points, and one of two megabytes is not.
  std::string ring = "M 0 0 l 0 1000 1000 0";
  const std::string there_and_back = " 0 1" + std::string(99, '0') + "e-99 0 -1";
  while (ring.size() + there_and_back.size() < (std::size_t{1} << 20U) - 100)
    ring += there_and_back;
  const std::string path = "<path d=\"" + ring + " z\"/>";
  CHECK(area_of(path + path) == Approx(0.5));
  while (ring.size() < (std::size_t{9} << 18U))
    ring += there_and_back;
  CHECK(testing::lacking(refusal_of(svg("<path d=\"" + ring + " z\"/>")), {"tags are too long"}).empty());
  const std::string layer = svg(kFlag);
  OutlineArchive opened(archive_of({layer, layer}));
  CHECK(testing::lacking(testing::message_of<ModelError>([&] { (void)opened.read(kOutlinePanel, 10); }),
                         {"memory", "print the model itself"})
            .empty());
  std::stop_source stop;
  stop.request_stop();
  CHECK(read_outlines(opened.archive(), kOutlinePanel, kEnoughMemory, stop.get_token())->layers() == 0);
}

TEST_CASE("Pictures and outlines are read each in their own way") {
  OutlineArchive opened(archive_of({svg(kFlag)}));
  CHECK(opened.archive().has_outlines());
  CHECK(contract_broken_by([&] { (void)opened.archive().read(kOutlinePanel, kEnoughMemory, {}); }) ==
        "the archive has pictures");
  OutlineArchive pictures({{"config.ini", "layerHeight = 0.05\n"}, {"part00000.png", "x"}});
  CHECK_FALSE(pictures.archive().has_outlines());
  CHECK(contract_broken_by([&] { (void)pictures.read(); }) == "the archive has outlines");
}
