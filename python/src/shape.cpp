// SPDX-License-Identifier: Apache-2.0
#include "common.hpp"

namespace meltsim_python {

using meltsim::Shape;

namespace {

std::vector<Shape> shapes(const std::string& name, const nb::args& parts) {
  std::vector<Shape> list;
  for (nb::handle part : parts) {
    if (!nb::isinstance<Shape>(part)) wrong_type(name + ": expected shapes, got " + shown(part));
    list.push_back(nb::cast<Shape>(part));
  }
  return list;
}

/// What cannot be sampled is refused where it is made.
Shape valid(Shape shape) {
  expect(shape.validate());
  return shape;
}

}  // namespace

void bind_shape(nb::module_& m) {
  nb::class_<Shape>(m, "Shape",
                    "A part of space [m]. Immutable. `a | b`, `a - b`, `a & b` unite, subtract, intersect.")
      .def_static(
          "box",
          [](const nb::args& args, const nb::kwargs& kwargs) {
            const auto a = arguments("box", {"min", "max"}, 2, args, kwargs);
            return valid(Shape::box(vector("min", a[0]), vector("max", a[1])));
          },
          nb::sig("def box(min: Sequence[typing.SupportsFloat] | numpy.ndarray, max: "
                  "Sequence[typing.SupportsFloat] | numpy.ndarray) -> Shape"),
          "Axis-aligned box between two corners.")
      .def_static(
          "sphere",
          [](const nb::args& args, const nb::kwargs& kwargs) {
            const auto a = arguments("sphere", {"center", "radius"}, 2, args, kwargs);
            return valid(Shape::sphere(vector("center", a[0]), number("radius", a[1])));
          },
          nb::sig("def sphere(center: Sequence[typing.SupportsFloat] | numpy.ndarray, radius: "
                  "typing.SupportsFloat) -> Shape"),
          "Ball.")
      .def_static(
          "capsule",
          [](const nb::args& args, const nb::kwargs& kwargs) {
            const auto a = arguments("capsule", {"a", "b", "radius"}, 3, args, kwargs);
            return valid(Shape::capsule(vector("a", a[0]), vector("b", a[1]), number("radius", a[2])));
          },
          nb::sig("def capsule(a: Sequence[typing.SupportsFloat] | numpy.ndarray, b: "
                  "Sequence[typing.SupportsFloat] | numpy.ndarray, radius: typing.SupportsFloat) -> Shape"),
          "All points within `radius` of the segment from `a` to `b`.")
      .def_static(
          "cylinder",
          [](const nb::args& args, const nb::kwargs& kwargs) {
            const auto a = arguments("cylinder", {"a", "b", "radius"}, 3, args, kwargs);
            return valid(Shape::cylinder(vector("a", a[0]), vector("b", a[1]), number("radius", a[2])));
          },
          nb::sig("def cylinder(a: Sequence[typing.SupportsFloat] | numpy.ndarray, b: "
                  "Sequence[typing.SupportsFloat] | numpy.ndarray, radius: typing.SupportsFloat) -> Shape"),
          "Cylinder with flat ends at `a` and `b`.")
      .def_static(
          "torus",
          [](const nb::args& args, const nb::kwargs& kwargs) {
            const auto a =
                arguments("torus", {"center", "axis", "major_radius", "minor_radius"}, 4, args, kwargs);
            return valid(Shape::torus(vector("center", a[0]), vector("axis", a[1]),
                                      number("major_radius", a[2]), number("minor_radius", a[3])));
          },
          nb::sig("def torus(center: Sequence[typing.SupportsFloat] | numpy.ndarray, axis: "
                  "Sequence[typing.SupportsFloat] | numpy.ndarray, major_radius: typing.SupportsFloat, "
                  "minor_radius: typing.SupportsFloat) -> Shape"),
          "Ring.")
      .def_static(
          "blend",
          [](const nb::args& args, const nb::kwargs& kwargs) {
            const auto a = arguments("blend", {"centers", "radii", "blend"}, 2, args, kwargs);
            const auto at = points("centers", a[0]), axes = points("radii", a[1]);
            if (at.size() != axes.size())
              refuse("radii: expected as many as centers, " + std::to_string(at.size()) + ", got " +
                     std::to_string(axes.size()));
            std::vector<meltsim::Ellipsoid> parts;
            for (std::size_t k = 0; k < at.size(); ++k) parts.push_back({at[k], axes[k]});
            return valid(Shape::blend(std::move(parts), a[2] ? number("blend", a[2]) : 0));
          },
          nb::sig("def blend(centers: numpy.typing.ArrayLike, radii: numpy.typing.ArrayLike, blend: "
                  "typing.SupportsFloat = 0.0) -> Shape"),
          "Smooth union of ellipsoids along the axes: centers and half axes (n, 3); neighbours merge over "
          "the "
          "width blend [m].")
      .def_static(
          "mesh",
          [](const nb::args& args, const nb::kwargs& kwargs) {
            const auto a = arguments("mesh", {"vertices", "triangles"}, 2, args, kwargs);
            meltsim::TriangleMesh mesh;
            mesh.vertices = points("vertices", a[0]);
            mesh.indices = triangles("triangles", a[1]);
            return valid(Shape::mesh(std::move(mesh)));
          },
          nb::sig("def mesh(vertices: numpy.typing.ArrayLike, triangles: numpy.typing.ArrayLike) -> Shape"),
          "Inside of a triangle mesh: vertices of shape (n, 3) [m] and indices of shape (m, 3), from 0.")
      .def_static(
          "from_file",
          [](const nb::args& args, const nb::kwargs& kwargs) {
            const auto a = arguments("from_file", {"path"}, 1, args, kwargs);
            const nb::object path = nb::steal(PyOS_FSPath(a[0].ptr()));
            PyErr_Clear();
            if (!path) wrong_type("path: expected the path of a file, got " + shown(a[0]));
            return valid(Shape::mesh(expect(meltsim::read_mesh(text("path", path)))));
          },
          nb::sig("def from_file(path: str | os.PathLike[str]) -> Shape"),
          "Inside of the mesh of an OBJ, STL or PLY file.")
      .def_static(
          "unite", [](nb::args parts) { return Shape::unite(shapes("unite", parts)); },
          nb::sig("def unite(*parts: Shape) -> Shape"), "Points in at least one part.")
      .def_static(
          "intersect", [](nb::args parts) { return Shape::intersect(shapes("intersect", parts)); },
          nb::sig("def intersect(*parts: Shape) -> Shape"), "Points in every part.")
      .def(
          "__or__",
          [](const Shape& a, const Shape& b) {
            return Shape::unite({a, b});
          },
          nb::is_operator())
      .def(
          "__and__",
          [](const Shape& a, const Shape& b) {
            return Shape::intersect({a, b});
          },
          nb::is_operator())
      .def(
          "__sub__", [](const Shape& a, const Shape& b) { return Shape::subtract(a, b); }, nb::is_operator())
      .def(
          "transformed",
          [](const Shape& s, const nb::args& args, const nb::kwargs& kwargs) {
            const auto a = arguments("transformed", {"offset", "axis", "angle", "scale"}, 0, args, kwargs);
            return valid(s.transformed(a[0] ? vector("offset", a[0]) : meltsim::Vec3d{0, 0, 0},
                                       a[1] ? vector("axis", a[1]) : meltsim::Vec3d{0, 1, 0},
                                       a[2] ? number("angle", a[2]) : 0, a[3] ? number("scale", a[3]) : 1));
          },
          nb::sig("def transformed(self, offset: Sequence[typing.SupportsFloat] | numpy.ndarray = (0, 0, 0), "
                  "axis: Sequence[typing.SupportsFloat] | numpy.ndarray = (0, 1, 0), angle: "
                  "typing.SupportsFloat = 0.0, scale: typing.SupportsFloat = 1.0) -> Shape"),
          "The shape moved: x -> scale R x + offset, R = rotation about `axis` by `angle` [rad].")
      .def(
          "contains",
          [](const Shape& s, const nb::args& args, const nb::kwargs& kwargs) {
            return s.contains(vector("point", arguments("contains", {"point"}, 1, args, kwargs)[0]));
          },
          nb::sig("def contains(self, point: Sequence[typing.SupportsFloat] | numpy.ndarray) -> bool"),
          "Whether the point [m] is inside.")
      .def_prop_ro(
          "bounds",
          [](const Shape& s) {
            const auto b = s.bounds();
            return nb::make_tuple(tuple3(b.min), tuple3(b.max));
          },
          nb::sig("def bounds(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]"),
          "Smallest box around it: lower and upper corner [m].")
      .def(
          "__copy__", [](nb::handle self) { return nb::borrow(self); },
          nb::sig("def __copy__(self) -> Shape"))
      .def(
          "__deepcopy__", [](nb::handle self, nb::handle) { return nb::borrow(self); }, "memo"_a,
          nb::sig("def __deepcopy__(self, memo: Any) -> Shape"))
      .def("__repr__", [](const Shape& s) {
        if (s.empty()) return std::string("<meltsim.Shape: empty>");
        const auto b = s.bounds();
        return "<meltsim.Shape within " +
               std::string(nb::repr(nb::make_tuple(tuple3(b.min), tuple3(b.max))).c_str()) + ">";
      });
}

}  // namespace meltsim_python
