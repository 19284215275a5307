#include "daemon/formats/svg_layer.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "core/model/model.hpp"
#include "daemon/formats/xml_reader.hpp"
#include "daemon/json/config_error.hpp"

namespace contourd {
namespace {

constexpr std::string_view kSvgName = "http://www.w3.org/2000/svg|";
constexpr double kLargestSvgMm = 1000;
// Units of a viewBox: ten metres in nanometres.
constexpr double kLargestViewBox = 1e10;

bool is_separator(char c) {
  return c == ' ' || c == ',' || (c >= '\t' && c <= '\r');
}

// The letters and numbers of an attribute, read one after another.
class SvgText {
 public:
  explicit SvgText(std::string_view text) : text_(text) {}

  [[nodiscard]] bool at_end() {
    skip();
    return text_.empty();
  }
  // Returns the next letter; nullopt if something else follows.
  [[nodiscard]] std::optional<char> letter() {
    skip();
    if (text_.empty()) return std::nullopt;
    const char c = text_.front();
    if ((c < 'a' || c > 'z') && (c < 'A' || c > 'Z')) return std::nullopt;
    text_.remove_prefix(1);
    return c;
  }
  // Returns the next number; nullopt if something else follows, or no finite number.
  [[nodiscard]] std::optional<double> number() {
    skip();
    std::string_view rest = text_;
    if (rest.starts_with('+')) rest.remove_prefix(1);
    // from_chars() would take "inf" and "nan".
    const std::size_t digits = rest.starts_with('-') ? 1 : 0;
    if (rest.size() <= digits || (rest[digits] != '.' && (rest[digits] < '0' || rest[digits] > '9')))
      return std::nullopt;
    double value = 0;
    const auto [after, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (error != std::errc{} || !std::isfinite(value)) return std::nullopt;
    text_ = rest.substr(static_cast<std::size_t>(after - rest.data()));
    return value;
  }
  [[nodiscard]] std::string_view rest() const { return text_; }

 private:
  void skip() {
    while (!text_.empty() && is_separator(text_.front()))
      text_.remove_prefix(1);
  }

  std::string_view text_;
};

Millimeters length_of(const XmlAttributes& attributes, const char* name) {
  SvgText text(attributes.text(name));
  const std::optional<double> value = text.number();
  if (!value || text.rest() != "mm" || !(*value > 0 && *value <= kLargestSvgMm))
    throw ModelError(
        fmt::format("the {} of the SVG picture is {}, and a length such as 96mm is needed: slice "
                    "the model again",
                    name, in_quotes(attributes.text(name))));
  return Millimeters{*value};
}

// Reads the elements of a layer.
class SvgLayerReader : public XmlHandler {
 public:
  explicit SvgLayerReader(SvgLayer& layer) : layer_(layer) {}

  [[nodiscard]] bool may_name_type() const override { return true; }

  void open(std::string_view name, const XmlAttributes& attributes) override {
    if (name.starts_with(kSvgName)) name.remove_prefix(kSvgName.size());
    if (is_open_ == (name == "svg"))
      throw ModelError(
          fmt::format("{} is not expected here, because a layer is one <svg> element: slice the "
                      "model again",
                      in_quotes(name)));
    if (attributes.find("transform") != nullptr)
      throw ModelError(fmt::format(
          "{} has a transform, and outlines without any are needed: slice the model again", in_quotes(name)));
    check_filled(name, attributes);
    if (!is_open_) return open_picture(attributes);
    if (name == "path") return add_path(attributes);
    if (name != "g" && name != "title" && name != "desc")
      throw ModelError(
          fmt::format("the element {} is no outline: only paths can be printed, as PrusaSlicer "
                      "writes them",
                      in_quotes(name)));
  }

  void check_end() const {
    if (!is_open_) throw ModelError("it holds no <svg> element: slice the model again");
  }

 private:
  // Refuses elements that other programs would not fill by the non-zero rule, or not at their place.
  static void check_filled(std::string_view name, const XmlAttributes& attributes) {
    const std::string_view style = attributes.text("style"), rule = attributes.text("fill-rule");
    const auto styles = [style](std::string_view word) { return style.find(word) != std::string_view::npos; };
    if (rule == "evenodd" || styles("evenodd"))
      throw ModelError(fmt::format(
          "{} has the fill rule evenodd, and nonzero is needed: slice the model again", in_quotes(name)));
    if (styles("transform") || styles("display:none") || styles("display: none") ||
        attributes.text("display") == "none")
      throw ModelError(fmt::format(
          "{} is moved or hidden by its style, and plain outlines are needed: slice the model again",
          in_quotes(name)));
  }

  void open_picture(const XmlAttributes& attributes) {
    is_open_ = true;
    layer_.size = {length_of(attributes, "width"), length_of(attributes, "height")};
    SvgText box(attributes.text("viewBox"));
    std::array<double, 4> figures{};
    for (double& figure : figures) {
      const std::optional<double> value = box.number();
      if (!value || std::fabs(*value) > kLargestViewBox) refuse_view_box(attributes);
      figure = *value;
    }
    if (!box.at_end() || figures[2] <= 0 || figures[3] <= 0) refuse_view_box(attributes);
    mm_per_unit_ = {layer_.size.width.count() / figures[2], layer_.size.height.count() / figures[3]};
    middle_ = {figures[0] + figures[2] / 2, figures[1] + figures[3] / 2};
  }

  [[noreturn]] static void refuse_view_box(const XmlAttributes& attributes) {
    throw ModelError(
        fmt::format("the viewBox of the SVG picture is {}, and four numbers such as \"0 0 96000 "
                    "54000\" are needed: slice the model again",
                    in_quotes(attributes.text("viewBox"))));
  }

  void add_path(const XmlAttributes& attributes) {
    SvgText path(attributes.text("d"));
    at_ = start_ = {0, 0};
    is_in_ring_ = false;
    char command = 0;
    while (!path.at_end()) {
      const std::optional<char> letter = path.letter();
      if (letter) {
        command = *letter;
        begin(command);
        // A letter without numbers: a ring of one point.
        if (!is_number_next(path)) continue;
      }
      move_by(command, path);
      if (command == 'M') command = 'L';  // further pairs are sides (SVG 1.1, 8.3.2)
      if (command == 'm') command = 'l';
    }
    if (is_in_ring_) throw ModelError("a ring of an outline is not closed by z: slice the model again");
  }

  [[nodiscard]] static bool is_number_next(SvgText path) { return path.number().has_value(); }

  // Begins a command: ends the ring, or checks that one is begun.
  void begin(char command) {
    switch (command) {
      case 'M':
      case 'm':
        if (is_in_ring_) throw ModelError("a ring of an outline is not closed by z: slice the model again");
        return;
      case 'Z':
      case 'z':
        end_ring();
        return;
      case 'L':
      case 'l':
      case 'H':
      case 'h':
      case 'V':
      case 'v':
        if (!is_in_ring_) begin_ring(start_);
        return;
      default:
        throw ModelError(
            fmt::format("an outline has the command {}, and only straight sides can be printed "
                        "(M, L, H, V, Z): slice the model again",
                        in_quotes(std::string_view(&command, 1))));
    }
  }

  void move_by(char command, SvgText& path) {
    const bool is_relative = command >= 'a';
    const Point from = is_relative ? at_ : Point{0, 0};
    switch (command) {
      case 'H':
      case 'h':
        at_.x = from.x + next(path);
        break;
      case 'V':
      case 'v':
        at_.y = from.y + next(path);
        break;
      case 'Z':
      case 'z':
      case 0:
        throw ModelError("an outline has numbers without a command: slice the model again");
      default:
        at_.x = from.x + next(path);
        at_.y = from.y + next(path);
    }
    if (command == 'M' || command == 'm') return begin_ring(at_);
    add_point();
  }

  static double next(SvgText& path) {
    const std::optional<double> value = path.number();
    if (value) return *value;
    constexpr std::size_t kShown = 20;
    throw ModelError(fmt::format("an outline has {} where a number is needed: slice the model again",
                                 in_quotes(path.rest().substr(0, kShown))));
  }

  void begin_ring(Point start) {
    at_ = start_ = start;
    is_in_ring_ = true;
    layer_.rings.loops.push_back({static_cast<std::uint32_t>(layer_.rings.points.size()), 0});
    add_point();
  }

  void end_ring() {
    if (!is_in_ring_) return;
    is_in_ring_ = false;
    at_ = start_;
    // Rings of one or two points, which slicers leave of tiny details, enclose nothing.
    ContourLoop& ring = layer_.rings.loops.back();
    if (ring.point_count >= 3) return;
    layer_.rings.points.resize(ring.first_point);
    layer_.rings.loops.pop_back();
  }

  void add_point() {
    if (layer_.rings.points.size() >= kMostSvgPoints)
      throw ModelError(
          fmt::format("the layer has more than {} points: print the model itself", kMostSvgPoints));
    const Point mm{(at_.x - middle_.x) * mm_per_unit_.x, (middle_.y - at_.y) * mm_per_unit_.y};
    // A later check reports by how much outlines near the picture reach over the plate.
    constexpr double kNear = 1.5;  // widths and heights
    if (!(std::fabs(mm.x) <= kNear * layer_.size.width.count() &&
          std::fabs(mm.y) <= kNear * layer_.size.height.count()))
      throw ModelError(
          fmt::format("an outline has the point {:g}, {:g}, far beside the viewBox: slice the model again",
                      at_.x, at_.y));
    layer_.rings.points.push_back(mm);
    ++layer_.rings.loops.back().point_count;
  }

  SvgLayer& layer_;
  bool is_open_ = false, is_in_ring_ = false;
  Point mm_per_unit_{}, middle_{};
  Point at_{}, start_{};  // in units of the viewBox
};

}  // namespace

void read_svg_layer(ByteStream& stream, const std::string& name, SvgLayer& layer) {
  layer.rings.points.clear();
  layer.rings.loops.clear();
  SvgLayerReader reader(layer);
  read_xml(stream, reader, name);
  reader.check_end();
}

}  // namespace contourd
