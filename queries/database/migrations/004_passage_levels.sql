-- Levels of random passages.

CREATE TABLE passage_levels (
    case_id VARCHAR NOT NULL, approach VARCHAR NOT NULL, receiver VARCHAR, offset_m DOUBLE, component VARCHAR, metric VARCHAR,
    statistic VARCHAR, value DOUBLE, unit VARCHAR, run_id VARCHAR, model_version VARCHAR, unit_id VARCHAR, source INTEGER
);
COMMENT ON TABLE passage_levels IS 'Levels of random passages, free field, over realisations of the unevenness: sites, not trains';
COMMENT ON COLUMN passage_levels.case_id IS 'Case, see cases';
COMMENT ON COLUMN passage_levels.approach IS 'Approach of the prediction';
COMMENT ON COLUMN passage_levels.receiver IS 'rail or ground';
COMMENT ON COLUMN passage_levels.offset_m IS 'Distance of a ground receiver from the track centre, m; NULL on the rail';
COMMENT ON COLUMN passage_levels.component IS 'z: vertical, positive downward';
COMMENT ON COLUMN passage_levels.metric IS 'kb-f-max, v-max-fast, v-max-slow, ppv, vdv, or third-octave-max-fast and the band';
COMMENT ON COLUMN passage_levels.statistic IS 'mean over passages; expected: of the mean square, or of the fourth power for vdv, exact; q0.05 and so on: quantile';
COMMENT ON COLUMN passage_levels.value IS 'Value in the unit of its row';
COMMENT ON COLUMN passage_levels.unit IS 'Unit of the value; 1 for KB';
COMMENT ON COLUMN passage_levels.run_id IS 'Run that computed it, see runs';
COMMENT ON COLUMN passage_levels.model_version IS 'Version of the physical model';
COMMENT ON COLUMN passage_levels.unit_id IS 'Unit it comes from, see units';
COMMENT ON COLUMN passage_levels.source IS 'Run directory, see sources';
