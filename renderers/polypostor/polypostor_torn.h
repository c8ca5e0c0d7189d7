// How far outlines that are shown are from those that are wanted, and what of that is seen. Texels of level 0 on a
// view's capture plane, y up, as in polypostor_contour.h.
#pragma once
#include "renderers/polypostor/polypostor_contour.h"

namespace crowdbench::renderers {

// The outline of one part in one pose, that many others are compared with. It refers to the outline and to the figure,
// the mask of all parts in that pose.
class WantedOutline {
 public:
  // slack: texels beside an outline where nothing is torn yet.
  WantedOutline(const Polyline& wanted, const PartMask& figure, double slack);

  const Polyline& line() const { return line_.line(); }
  double perimeter() const { return line_.perimeter(); }

  // How torn the figure is where `shown` stands for what is wanted: the area, square texels, that lies between the two
  // farther than the slack from one of them, in so far as it is seen. What is shown too much is not seen in front of
  // the figure, and what is missing is not where the figure goes on beyond the outline. 0 where either is empty.
  double torn(const Polyline& shown) const;

  // The area, square texels, between evenly spread points of an outline and the line that is wanted: their mean
  // distance times its length.
  double area_between(const Polyline& points) const;

  // Whether the figure leaves one of the four places a texel away from a point uncovered.
  bool shows(const glm::dvec2& p) const;

 private:
  IndexedLine line_;
  const PartMask* figure_;
  double slack_;
  Polyline seen_;  // those of its evenly spread points that the figure does not go on beyond
};

double area_between(const Polyline& points, const IndexedLine& wanted);

}  // namespace crowdbench::renderers
