/* A topic of CycloneDDS whose samples are so many bytes: what src/middleware/cyclonedds.rs calls. */

#include <dds/dds.h>
#include <stdint.h>
#include <stdlib.h>

struct timegap_dds {
    dds_entity_t participant;
    dds_entity_t end;
    dds_entity_t waitset;
    uint32_t operations[4];
};

/* Opens the writing or the reading end. Returns 0, or the library's negative code. */
int timegap_dds_open(uint32_t domain, const char *configuration, uint32_t bytes, int writes,
                     struct timegap_dds **opened)
{
    struct timegap_dds *dds = calloc(1, sizeof *dds);
    dds_entity_t made = dds_create_domain(domain, configuration);
    dds_return_t failed = made;
    /* A domain that the other end has made in this process serves both. */
    if (dds == NULL || (made < 0 && made != DDS_RETCODE_PRECONDITION_NOT_MET))
        goto release;
    dds->participant = dds_create_participant(domain, NULL, NULL);
    if ((failed = dds->participant) < 0)
        goto release;

    /* As the library's code generator writes it for `struct RadarTracks { octet bytes[N]; };`. */
    dds->operations[0] = DDS_OP_ADR | DDS_OP_TYPE_ARR | DDS_OP_SUBTYPE_1BY;
    dds->operations[1] = 0;
    dds->operations[2] = bytes;
    dds->operations[3] = DDS_OP_RTS;
    const dds_topic_descriptor_t descriptor = {
        .m_size = bytes,
        .m_align = 1,
        .m_flagset = DDS_TOPIC_FIXED_SIZE,
        .m_typename = "timegap::RadarTracks",
        .m_nops = 2,
        .m_ops = dds->operations,
        .m_meta = "",
    };
    dds_entity_t topic =
        dds_create_topic(dds->participant, &descriptor, "radar_tracks", NULL, NULL);
    if ((failed = topic) < 0)
        goto release;
    dds_qos_t *qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(10));
    dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
    dds->end = writes ? dds_create_writer(dds->participant, topic, qos, NULL)
                      : dds_create_reader(dds->participant, topic, qos, NULL);
    dds_delete_qos(qos);
    if ((failed = dds->end) < 0)
        goto release;
    if (!writes) {
        dds->waitset = dds_create_waitset(dds->participant);
        dds_entity_t unread = dds_create_readcondition(dds->end, DDS_ANY_STATE);
        if ((failed = dds->waitset) < 0 || (failed = unread) < 0 ||
            (failed = dds_waitset_attach(dds->waitset, unread, 0)) < 0)
            goto release;
    }
    *opened = dds;
    return 0;

release:
    if (dds != NULL && dds->participant > 0)
        dds_delete(dds->participant);
    free(dds);
    return failed;
}

/* Readers that the writer knows, or the library's negative code. */
int timegap_dds_readers(struct timegap_dds *dds)
{
    dds_publication_matched_status_t status;
    dds_return_t failed = dds_get_publication_matched_status(dds->end, &status);
    return failed < 0 ? failed : (int)status.current_count;
}

/* Sends one sample. Returns 0, or the library's negative code. */
int timegap_dds_write(struct timegap_dds *dds, const void *sample)
{
    return dds_write(dds->end, sample);
}

/* Waits until there is a sample, at most so many nanoseconds. */
int timegap_dds_wait(struct timegap_dds *dds, int64_t timeout_ns)
{
    dds_attach_t ready;
    return dds_waitset_wait(dds->waitset, &ready, 1, timeout_ns);
}

/* Copies the oldest sample to `sample`. Returns 1, 0 if there is none, or the library's negative code. */
int timegap_dds_take(struct timegap_dds *dds, void *sample)
{
    dds_sample_info_t info;
    void *samples[1] = {sample};
    dds_return_t taken = dds_take(dds->end, samples, &info, 1, 1);
    return taken == 1 && !info.valid_data ? 0 : taken;
}

/* Closes an end. */
void timegap_dds_close(struct timegap_dds *dds)
{
    dds_delete(dds->participant);
    free(dds);
}
