// OpenSceneGraph's LiSPSM: the steps of MinimalShadowMap and ProjectionShadowMap for one directional light, by the library's own
// polyhedra and its LightSpacePerspectiveShadowMapAlgorithm, without the walk through a scene graph.
#include <osg/Camera>
#include <osg/Polytope>
#include <osg/Version>
#include <osgShadow/ConvexPolyhedron>
#include <osgShadow/LightSpacePerspectiveShadowMap>

#include "protocol.h"

int main(int count, char** texts) {
    const Given g = given(count, texts);
    const osg::ref_ptr<osg::Camera> eye = new osg::Camera, shadow = new osg::Camera;
    eye->setViewMatrixAsLookAt(
        osg::Vec3d(g.eye[0], g.eye[1], g.eye[2]), osg::Vec3d(g.target[0], g.target[1], g.target[2]), osg::Vec3d(0, 1, 0));
    eye->setProjectionMatrixAsPerspective(g.fov_deg, 1, g.near, g.far);
    osg::Vec3d towards(g.light[0], g.light[1], g.light[2]);
    towards.normalize();
    const osg::BoundingBox box(g.least[0], g.least[1], g.least[2], g.most[0], g.most[1], g.most[2]);
    const osgShadow::LightSpacePerspectiveShadowMapAlgorithm lispsm;
    auto clip = [&] { return shadow->getViewMatrix() * shadow->getProjectionMatrix(); };
    auto fit = [&] {
        osgShadow::ConvexPolyhedron receivers;
        receivers.setToBoundingBox(box);
        auto cut = [&](const osg::Matrix& clip_from_world) {
            osg::Polytope frustum;
            frustum.setToUnitFrustum();
            frustum.transformProvidingInverse(clip_from_world);
            receivers.cut(frustum);
        };
        // trimProjection: the projection's cube about the receivers.
        auto trim = [&] {
            const osg::BoundingBox b = receivers.computeBoundingBox(clip());
            shadow->setProjectionMatrix(
                shadow->getProjectionMatrix() *
                osg::Matrix::ortho(b._min[0], b._max[0], b._min[1], b._max[1], -b._min[2], -b._max[2]));
        };
        cut(eye->getViewMatrix() * eye->getProjectionMatrix());
        // aimShadowCastingCamera: from outside of the receivers' sphere, up along the view.
        const osg::BoundingBox about = receivers.computeBoundingBox(osg::Matrix());
        const osg::Vec3d middle = about.center();
        const double radius = about.radius();
        const osg::Matrix world_from_eye = osg::Matrix::inverse(eye->getViewMatrix());
        const osg::Vec3d up(-world_from_eye(2, 0), -world_from_eye(2, 1), -world_from_eye(2, 2));
        shadow->setViewMatrixAsLookAt(middle - towards * (2 * radius), middle, up);
        shadow->setProjectionMatrixAsOrtho(-radius, radius, -radius, radius, radius, 3 * radius);
        cut(clip());
        trim();
        lispsm(&receivers, eye.get(), shadow.get());
        trim();
    };
    fit();
    char about[64];
    std::snprintf(about, sizeof about, "OpenSceneGraph %s", osgGetVersion());
    serve(about, g.calls, fit);
}
