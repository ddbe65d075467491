// SPDX-License-Identifier: GPL-3.0-or-later
/** moulage in MeshLab: a template of an organ, bone or skeleton in one person's shape. */
#ifndef MOULAGE_FILTER_MOULAGE_H
#define MOULAGE_FILTER_MOULAGE_H

#include <common/plugins/interfaces/filter_plugin.h>

class FilterMoulage : public QObject, public FilterPlugin {
    Q_OBJECT
    MESHLAB_PLUGIN_IID_EXPORTER(FILTER_PLUGIN_IID)
    Q_INTERFACES(FilterPlugin)

public:
    enum { RESHAPE, REGISTER, SEPARATE, TETRAHEDRALIZE, DISTANCE };

    FilterMoulage();

    QString pluginName() const override { return "FilterMoulage"; }
    QString vendor() const override { return "moulage"; }
    QString filterName(ActionIDType filter) const override;
    QString pythonFilterName(ActionIDType filter) const override;
    QString filterInfo(ActionIDType filter) const override;
    FilterClass getClass(const QAction *action) const override;
    FilterArity filterArity(const QAction *action) const override;
    int getPreConditions(const QAction *action) const override;
    int postCondition(const QAction *action) const override;
    RichParameterList initParameterList(const QAction *action, const MeshDocument &document) override;
    std::map<std::string, QVariant> applyFilter(const QAction *action,
                                                const RichParameterList &parameters,
                                                MeshDocument &document,
                                                unsigned int &postConditionMask,
                                                vcg::CallBackPos *callback) override;

private:
    using Figures = std::map<std::string, QVariant>;
    Figures reshape(const RichParameterList &parameters, MeshDocument &document,
                    vcg::CallBackPos *callback);
    Figures register_skeleton(const RichParameterList &parameters, MeshDocument &document,
                              vcg::CallBackPos *callback);
    Figures separate(const RichParameterList &parameters, MeshDocument &document,
                     vcg::CallBackPos *callback);
    Figures tetrahedralize(const RichParameterList &parameters, MeshDocument &document,
                           vcg::CallBackPos *callback);
    Figures distance(const RichParameterList &parameters, MeshDocument &document);
    /** Logs warnings, one per line, and counts them. */
    void warn(const std::string &sentences);

    int warnings_ = 0;
};

#endif
