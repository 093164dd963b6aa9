#pragma once

#include <Eigen/Core>
#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace armtrue {

/// What stands for what in every picture. Each look has a colour and, against colour blindness and
/// prints without colours, a shape of its own: dashes, outline or fill, mark.
enum class Look {
  nominal,  ///< grey: thin dashes, outlined bars, crosses
  before,   ///< vermilion: thin line, hatched bars, rings
  after,    ///< blue: thick line, filled bars, dots
  mark,     ///< the colour of the text: limits, rules, references
};

/// Ends and ticks of an axis.
struct Axis {
  double low = 0, high = 1;
  double step = 1;  ///< between ticks, which are multiples of it
  std::string label;

  double length() const { return high - low; }
};

/// An axis from tick to tick that holds both values, with a step of 1, 2 or 5 times a power of ten
/// and at most `most` steps.
Axis round_axis(double low, double high, const std::string& label, int most = 6);

/// An axis of counts, from 0 on: no step is below 1.
Axis count_axis(double high, const std::string& label, int most = 6);

/// As round_axis(), but with exactly these ends.
Axis exact_axis(double low, double high, const std::string& label, int most = 6);

/// A value with as many decimals as the ticks of an axis with this step have.
std::string tick_text(double value, double step);

/// Rows to draw, at most `most`: all, or evenly spread ones, the first and the last included.
std::vector<int> evenly(Eigen::Index rows, Eigen::Index most);

/// Rows to draw of a curve, at most `most`: each stretch keeps its smallest and its largest value.
std::vector<Eigen::Index> peaks_kept(const Eigen::VectorXd& values, Eigen::Index most);

using Points = std::vector<Eigen::Vector2d>;  // in the units of the axes
using Places = std::vector<Eigen::Vector3d>;

class Picture;

/// One pair of axes. Values must lie within the axes.
class Panel {
 public:
  /// Bars from `low` on, each `width` wide. `texts` say what each bar is, for a pointer and a
  /// reader.
  void bars(double low, double width, const std::vector<double>& heights,
            const std::vector<std::string>& texts, Look look, const std::string& name);
  /// `texts`, here and below: what each point or vector is, for a pointer; none if empty.
  void line(const Points& points, Look look, const std::string& name,
            const std::vector<std::string>& texts = {});
  /// Fills the area between two lines with the same x: the ends of an interval at each.
  void band(const Points& low, const Points& high, Look look, const std::string& name);
  void points(const Points& points, Look look, const std::string& name,
              const std::vector<std::string>& texts = {});
  /// Small grey marks of places, without a name in the legend.
  void dots(const Points& points);
  void vectors(const Points& from, const Points& to, Look look, const std::string& name,
               const std::vector<std::string>& texts = {});
  /// From (x, low) to (x, high), with end strokes, and a mark of the look at (x, middle).
  void range(double x, double low, double middle, double high, Look look, const std::string& name,
             const std::string& text);
  /// Squares about points, whose class (0 to kHeatClasses - 1) is colour and size.
  void cells(const Points& centres, const std::vector<int>& classes, double width, double height,
             const std::vector<std::string>& texts);
  /// A line across the whole panel, at x or at y.
  void rule_x(double x, Look look, const std::string& name);
  void rule_y(double y, Look look, const std::string& name);
  /// `anchor`: which part of the text is at (x, y): start, middle or end.
  void text(double x, double y, const std::string& text, const char* anchor);
  /// A text in the upper right corner.
  void corner(const std::string& text);

  // Of a panel of Picture::space(): places lie within a ball of radius 1, their z points upwards.
  /// `look`: empty for lines of the frame.
  void segments(const Places& from, const Places& to, std::optional<Look> look,
                const std::string& name, const std::vector<std::string>& texts = {});
  void dots(const Places& places);
  void label(const Eigen::Vector3d& place, const std::string& text);

 private:
  friend class Picture;
  Panel(Picture& picture, Axis x, Axis y, int height);
  double px(double x) const;
  double py(double y) const;
  std::string at(const Eigen::Vector2d& point) const;
  double ball_radius() const;
  Eigen::Vector2d projected(const Eigen::Vector3d& place) const;
  std::string frame(bool is_last) const;

  Picture* picture_;
  Axis x_, y_;
  int height_;
  bool is_space_ = false;
  std::string body_;
};

inline constexpr int kHeatClasses = 7;

/// An SVG picture: a title, a legend, and panels under each other above one horizontal axis. It
/// scales by its viewBox; its text is readable from a width of 340 px on. Colours are variables of
/// picture_style(). Text is escaped here.
class Picture {
 public:
  /// `name`: of the file, without .svg. `description`: for who does not see the picture.
  Picture(std::string name, std::string title, std::string description, Axis x);
  Picture(Picture&&) = delete;

  /// Adds a panel below the others; the reference stays valid.
  Panel& panel(const Axis& y, int height);
  /// The only panel of a picture in three dimensions, seen from a corner above. A page turns it.
  Panel& space(int height);
  /// An entry for classes of cells(), from `low` to `high` in this unit.
  void heat_legend(double low, double high, const std::string& unit);
  /// Words below the horizontal axis instead of its numbers.
  void words(std::vector<std::pair<double, std::string>> words) { words_ = std::move(words); }

  const std::string& name() const { return name_; }
  const std::string& title() const { return title_; }
  const std::string& description() const { return description_; }
  /// To stand in a page that has picture_style().
  std::string svg() const;

  /// Width of the panels, in the units of heights.
  static double panel_width();

 private:
  friend class Panel;
  friend std::string stand_alone(const std::vector<std::shared_ptr<Picture>>& pictures);
  void legend(const std::string& kind, Look look, const std::string& name);
  std::string legend_svg(double& top) const;
  std::string x_axis(double top) const;
  struct Content {
    double height;
    std::string svg;
  };
  Content content() const;

  struct Entry {
    std::string kind;
    Look look;
    std::string name;
  };
  std::string name_, title_, description_;
  Axis x_;
  std::deque<Panel> panels_;
  std::vector<Entry> entries_;
  std::vector<std::pair<double, std::string>> words_;
  std::array<std::string, 2> heat_;  // lowest and highest value
};

/// A picture that is drawn for a page; null: there is nothing to draw.
using Drawing = std::shared_ptr<Picture>;

/// Pictures as one file with a style of its own, two beside each other.
std::string stand_alone(const std::vector<Drawing>& pictures);

/// Axes of equal scale, and the height of their panel.
struct MapAxes {
  Axis x, y;
  int height;
};
/// The axes of a map that holds the corners `low` and `high`.
MapAxes map_axes(Eigen::Vector2d low, Eigen::Vector2d high, const std::string& x_label,
                 const std::string& y_label, double most_height = 340);

/// Colours, light and dark, and classes of all pictures: CSS for a page or a picture of its own.
const std::string& picture_style();

/// Text with the characters that HTML and XML reserve written as entities.
std::string escaped(const std::string& text);

}  // namespace armtrue
